"""A topic of reports: what kind of problems these are."""
