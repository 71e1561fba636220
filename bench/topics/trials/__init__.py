"""Whether trials suffice: the power of the tests, and their error rates."""
