"""The units of time, speed and position, and the parser of column headings such as ``speed [rpm]``."""

import re
from dataclasses import dataclass
from math import pi

TIME = {"s": 1.0, "ms": 1e3, "us": 1e6}
"""The number of each unit in one second."""

SPEED = {"rps": 1.0, "rpm": 60.0, "rad/s": 2 * pi, "deg/s": 360.0}
"""The number of each unit in one turn per second."""

POSITION = {"rev": 1.0, "rad": 2 * pi, "deg": 360.0}
"""The number of each unit in one turn."""

SPELLINGS = {
    "s": ("sec", "second", "seconds", "sek"),
    "ms": ("msec", "millis", "milliseconds"),
    "us": ("usec", "micros", "microseconds"),
    "rps": ("1/s", "rev/s", "u/s", "hz", "s-1", "s^-1"),
    "rpm": ("1/min", "rev/min", "u/min", "min-1", "min^-1"),
    "rad/s": ("rad_s", "rad/sec", "radps", "rad s-1", "rad s^-1"),
    "deg/s": ("deg_s", "deg/sec", "degps"),
    "rev": ("turn", "turns", "revs", "revolutions"),
    "rad": ("radian", "radians"),
    "deg": ("degree", "degrees"),
}
"""Other spellings of the units, without regard to case; ° is read as deg and a micro sign as u."""

WORDS = {
    "time": {"time", "t", "zeit", "tempo", "temps", "tiempo", "timestamp"},
    "speed": {"speed", "velocity", "vel", "omega", "v", "w", "drehzahl", "geschwindigkeit", "velocità", "vitesse"},
    "position": {"position", "pos", "angle", "theta", "phi", "winkel", "lage", "posizione", "angolo", "encoder"},
}
"""The words in a heading that identify the role of a column."""

OTHER = {"load", "link", "l", "ref", "reference", "command", "cmd", "set", "setpoint", "target", "nominal", "soll"}
"""Words in the heading of a column that is not a measurement of the motor."""

MOTOR = {"motor", "m", "motore", "moteur"}

_UNITS = {spelling: unit for unit, others in SPELLINGS.items() for spelling in (unit, *others)}
_SUFFIX = re.compile(r"(?:^|[\s_/,])(" + "|".join(map(re.escape, sorted(_UNITS, key=len, reverse=True))) + r")\)?$")
_BRACKET = re.compile(r"([\[(])([^\[\]()]*)[\])]$")


@dataclass(frozen=True)
class Heading:
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
    role = next((role for role, known in WORDS.items() if known & set(words)), "")
    if not words and unit is not None:  # a column called "rpm"
        role = next(role for role, units in UNITS.items() if unit in units)
    rank = (bool(OTHER & set(words)), not MOTOR & set(words), len(words))
    return Heading(role, rank, text.strip(" _/,"), unit, unknown)


UNITS = {"time": TIME, "speed": SPEED, "position": POSITION}


def _spelled(text: str) -> str:
    return text.strip().lower().replace("µ", "u").replace("μ", "u").replace("°", "deg")
