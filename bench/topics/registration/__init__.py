"""A topic of reports: the registration of a study before its first trial, and whether it was followed."""
