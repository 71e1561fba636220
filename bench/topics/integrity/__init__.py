"""A topic of reports: the checks of the results themselves, and what is not compared."""
