"""The studies of the field's suites, one TOML file each; they need the extras ``suites`` and ``ioh``."""

from importlib.resources import files

bbob = files(__name__) / "bbob.toml"
bbob_quick = files(__name__) / "bbob-quick.toml"
cec2022 = files(__name__) / "cec2022.toml"
engineering = files(__name__) / "engineering.toml"
gnbg_f01_f15 = files(__name__) / "gnbg-f01-f15.toml"
gnbg_f16_f24 = files(__name__) / "gnbg-f16-f24.toml"
