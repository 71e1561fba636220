"""A topic of reports: the data of the interactive part."""
