"""Section 4 of the page, over the budget: the share of targets reached, who is ahead when, and running times."""
