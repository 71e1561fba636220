"""Read the results of one folder or several as frames: all trials, and those that are compared."""
