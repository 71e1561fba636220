"""The built-in problems, one subject a folder; that of backlash holds its commands, studies and reports too."""
