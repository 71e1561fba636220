"""The section “Every run”: all final values."""
