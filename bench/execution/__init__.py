"""Make the trials of a study: plan, workers, trial processes, and the runner that commits each finished trial."""
