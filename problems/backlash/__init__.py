"""Backlash of a robot joint: simulator, recordings, signature fit, virtual sensor, and their commands and reports."""

LEVELS = range(1, 21)
"""The levels of backlash that number the thesis's simulated datasets and the authors' recordings (section 7.2.1)."""
