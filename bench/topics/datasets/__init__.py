"""A topic of reports: every problem by itself."""
