"""A topic of reports: what was reached over the evaluations, and beside the best known values."""
