"""The section “Cost”: what the optimizers cost."""
