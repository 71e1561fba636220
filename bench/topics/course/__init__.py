"""The section “Over the budget”: what was reached when."""
