"""Backlash of a robot joint: simulator, recordings, signature fit, virtual sensor, and their commands and reports."""
