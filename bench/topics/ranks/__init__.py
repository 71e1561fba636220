"""A topic of reports: ranks, tests and effect sizes over all problems."""
