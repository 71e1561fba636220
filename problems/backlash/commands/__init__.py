"""Sub-commands of the command line that are about backlash."""
