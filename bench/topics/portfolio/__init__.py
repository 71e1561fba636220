"""A topic of reports: which optimizers to take, and advice for a problem."""
