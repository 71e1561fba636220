"""A topic of reports: the time of a trial, and the machines."""
