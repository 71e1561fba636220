"""The studies that come with the package, one TOML file each."""

from importlib.resources import files

thesis = files(__name__) / "thesis.toml"
quick = files(__name__) / "quick.toml"
