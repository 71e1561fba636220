"""A topic of reports: how optimizers were tuned."""
