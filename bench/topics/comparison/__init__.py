"""A topic of reports: medians, means, and feasibility of every optimizer on every problem."""
