"""A topic of reports: what differs between optimizers besides their algorithms, and what makes it alike."""
