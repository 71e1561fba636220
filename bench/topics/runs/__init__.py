"""Section 3 of the page, every run: a dot a run, the medians with their tests, and the map of ranks."""
