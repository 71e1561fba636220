"""The built-in optimizers, one a file; each registers through the entry points that an outside package uses."""
