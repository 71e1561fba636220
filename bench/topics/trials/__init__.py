"""A topic of reports: whether the trials suffice, and the power of the tests."""
