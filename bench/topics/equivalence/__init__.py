"""A topic of reports: practical equality."""
