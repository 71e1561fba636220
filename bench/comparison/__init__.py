"""Compare optimizers from Python, and a version with another in a gate."""
