"""The built-in problems, one family a folder, with all that is about backlash: commands, studies and report views."""
