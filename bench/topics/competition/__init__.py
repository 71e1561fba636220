"""A topic of reports: the table of competitions."""
