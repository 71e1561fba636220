"""The section “In your units”: the outcome in the units of the problems."""
