"""What folders hold, read as frames: one study or several, the trials as they are and as they are compared."""
