"""The studies that come with the package, one TOML file each."""

from importlib.resources import files

noise = files(__name__) / "noise.toml"
noise_start = files(__name__) / "noise-start.toml"
published = files(__name__) / "published.toml"
thesis = files(__name__) / "thesis.toml"
thesis_equal = files(__name__) / "thesis-equal.toml"
thesis_plus = files(__name__) / "thesis-plus.toml"
wrist = files(__name__) / "wrist.toml"
quick = files(__name__) / "quick.toml"
