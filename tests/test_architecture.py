"""ARCHITECTURE.md is true: its layers are those that lint enforces."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_the_layers_are_those_that_lint_enforces():
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(each for each in contracts if each["id"] == "bench")["layers"]
    enforced = [{*re.split(r"[ :|]+", floor)} - {"__main__"} for floor in layers]
    drawing = re.search(r"```\noptimizers \| problems.*?\n(─.*?)```", PAGE, re.DOTALL)[1]
    floors = re.split(r"^─.*\n", drawing, flags=re.MULTILINE)[1:]
    drawn = [
        [name for line in floor.splitlines() for name in re.split(r"\s{2,}", line)[0].split(", ")] for floor in floors
    ]
    assert [sorted(floor) for floor in drawn] == [sorted(floor) for floor in enforced]
