"""Backlash of a robot joint: simulator, recordings, signature fit, virtual sensor, and their commands and reports."""

LEVELS = range(1, 21)
"""The levels of backlash that number the thesis's simulated datasets and the authors' recordings (section 7.2.1)."""

TRUTH = "truth.csv"  # the file that 'bench simulate --wear' writes beside the recordings
EARLY_RAD = 0.0021  # rad; the largest of the ten half-gaps in section 7.3's test of the early stages of backlash
