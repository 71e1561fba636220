"""A topic of reports: what the parameters of a sweep contribute."""
