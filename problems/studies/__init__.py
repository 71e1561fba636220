"""The studies of the field's suites, one TOML file each; they need the extra ``suites``."""

from importlib.resources import files

bbob = files(__name__) / "bbob.toml"
bbob_quick = files(__name__) / "bbob-quick.toml"
cec2022 = files(__name__) / "cec2022.toml"
engineering = files(__name__) / "engineering.toml"
