"""The family ``classical``: textbook functions of global optimization, moved and rotated by an instance's number."""
