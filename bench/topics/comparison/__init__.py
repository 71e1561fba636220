"""A topic of reports: medians, means, feasibility and dominance of every optimizer on every problem."""
