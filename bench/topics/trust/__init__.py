"""The section “Can you trust it?”: what may limit the answer."""
