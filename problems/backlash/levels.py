"""The levels of backlash that number the thesis's simulated datasets and the authors' recordings (section 7.2.1)."""

LEVELS = range(1, 21)
