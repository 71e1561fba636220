"""A process of its own for plug-in code, and what such code changed in it."""
