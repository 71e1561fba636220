"""Read the role and the unit of a recording's columns from their headings."""

from __future__ import annotations

import re
import tomllib
from math import pi
from pathlib import Path
from typing import NamedTuple

UNITS = {
    "time": {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9},
    "speed": {"rps": 1.0, "rpm": 60.0, "rad/s": 2 * pi, "deg/s": 360.0},
    "position": {"rev": 1.0, "rad": 2 * pi, "deg": 360.0},
}
"""By the role of a column, the number of each unit in one second, one turn per second, and one turn."""

WORDS = tomllib.loads(Path(__file__).with_name("headings.toml").read_text(encoding="utf-8"))
_UNITS = {spelling: unit for unit, spellings in WORDS["units"].items() for spelling in (unit, *spellings)}
_SUFFIX = re.compile(r"(?:^|[\s_/,])(" + "|".join(map(re.escape, sorted(_UNITS, key=len, reverse=True))) + r")\)?$")
_BRACKET = re.compile(r"([\[(])([^\[\]()]*)[\])]$")


class Heading(NamedTuple):
    """The role and the unit of a column according to its heading.

    Attributes:
        role: "time", "speed", "position", or "" for any other column.
        rank: among several columns of a role, the one with the lowest rank is likeliest to be the motor's.
        plain: the heading without its unit, in lower case.
        unit: the unit that it names, or None.
        unknown: a unit in square brackets that is not in ``UNITS``, or "".
    """

    role: str
    rank: tuple[bool, bool, int]
    plain: str
    unit: str | None
    unknown: str


def is_unit(text: str) -> bool:
    """Return whether the text is a unit and nothing else, in brackets or not."""
    return _spelled(text).strip("[]() ") in _UNITS


def parse_heading(name: str) -> Heading:
    """Return the role and unit of a heading such as ``speed_rpm``, ``Drehzahl [1/min]`` or ``v (rad/s)``."""
    text, unit, unknown = _spelled(name), None, ""
    bracket = _BRACKET.search(text)
    if bracket and bracket[2].strip() in _UNITS:
        text, unit = text[: bracket.start()], _UNITS[bracket[2].strip()]
    elif bracket and bracket[1] == "[":  # round brackets hold remarks as well
        text, unknown = text[: bracket.start()], bracket[2].strip("- ")
    elif suffix := _SUFFIX.search(text):
        text, unit = text[: suffix.start()], _UNITS[suffix[1]]
    words = re.findall(r"[^\W\d_]+", text)
    role = next((role for role, spellings in WORDS["roles"].items() if {*spellings} & {*words}), "")
    if not words and unit is not None:  # a column called "rpm"
        role = next(role for role, units in UNITS.items() if unit in units)
    motor, not_motor = (bool({*WORDS["origins"][origin]} & {*words}) for origin in ("motor", "other"))
    rank = (not_motor, not motor, len(words))
    return Heading(role, rank, text.strip(" _/,"), unit, unknown)


def _spelled(text: str) -> str:
    return text.strip().lower().replace("µ", "u").replace("μ", "u").replace("°", "deg")
