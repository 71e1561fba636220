"""A topic of reports: running times and targets on the functions of a suite."""
