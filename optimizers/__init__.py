"""The built-in optimizers, one a file; each registers through the entry points that an outside package uses."""

from importlib.resources import files

atlas = files(__name__) / "atlas.toml"
"""The table of ``bench atlas``: which optimizers implement the same method."""
