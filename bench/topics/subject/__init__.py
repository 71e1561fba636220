"""A topic of reports: one optimizer, the subject of the study, against each of its rivals."""
