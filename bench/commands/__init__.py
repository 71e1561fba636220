"""The sub-commands of the command line, by what they work with."""
