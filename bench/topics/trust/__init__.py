"""The section “Can you trust it?”: one card with what may limit the answer."""
