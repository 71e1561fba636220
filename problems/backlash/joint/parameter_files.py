"""Read and write joints as TOML: the parameters of :class:`Joint`, or a payload, a speed and an axis angle instead."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from math import pi, radians, sin
from pathlib import Path
from typing import Any

from bench.errors import BenchError, nearest
from bench.numbers import is_finite, require_positive
from problems.backlash.joint.parameters import Joint

GRAVITY = 9.80665
"""Standard gravity, m/s²."""

PAYLOAD, LEVER = 5.0, 0.2943
"""kg and m; the point mass that makes the default joint's gravity torque and load inertia to within 3e-4 of each."""

LARGEST = 1e100
"""Larger numbers are no property of a joint, and a float cannot hold their cube."""

FIELDS = {field.name: field for field in fields(Joint)}

INSTEAD = {
    "payload_kg": ("gravity_torque", "load_inertia"),
    "lever_m": ("gravity_torque", "load_inertia"),
    "speed_rps": ("omega_ref",),
    "gravity_angle_deg": (),
}
"""Keys that a file may give instead of the joint's own parameters, and the parameters that each key sets."""


def load_joint(path: str | Path | None = None, **options: float | None) -> Joint:
    """Return the joint of a TOML file; a parameter that the file leaves out has the default joint's value.

    Besides the parameters of :class:`Joint`, in SI units, a file may give

    - ``payload_kg`` and ``lever_m``: a point mass m at the distance l from the axis, which makes the load's inertia
      m l² and its gravity torque m g l; one without the other is completed by 5 kg or 0.2943 m;
    - ``speed_rps``: the reference speed in motor turns per second;
    - ``gravity_angle_deg``: the angle between the joint's axis and the vertical, with whose sine the gravity torque
      is multiplied: 90 for a horizontal axis (the default), 0 for one parallel to gravity, as a robot's joint 1.

    A payload changes the load alone. The default joint's motor inertia, transmission and gains are known relative to
    its payload of 5 kg, and they stay: this is the same motor under the same controller with another load. For a
    controller that is tuned to its payload, a heavier joint's stiffer gear, or a payload beside a link with a mass of
    its own, give those parameters.

    Args:
        path: the file; None for the default joint.
        **options: values that replace the file's values of the same names; None keeps the file's value.

    Raises:
        BenchError: for a file that cannot be read, an unknown key, a value of the wrong type or out of range, and keys
            that contradict each other.
    """
    given = {key: value for key, value in options.items() if value is not None}
    settings = _read(Path(path)) if path is not None else {}
    for key in given:
        for other in INSTEAD.get(key, ()):
            settings.pop(other, None)
    return _joint(settings | given, "the joint" if path is None else f"joint {path}")


def joint_text(joint: Joint) -> str:
    """Return the text of a TOML file with all of the joint's parameters, their meanings and units, for editing."""
    lines = [f"{name} = {float(getattr(joint, name))!r}" for name in FIELDS]
    width = max(map(len, lines))
    rows = [
        f"{line:{width}}  # {field.metadata['meaning']}" for line, field in zip(lines, FIELDS.values(), strict=True)
    ]
    return "\n".join(
        [
            "# A robot joint for 'bench simulate --joint' and 'bench calibrate --joint', in SI units.",
            "# A line that is left out has the value of the thesis's test bench.",
            *rows,
            "",
            "# Instead of gravity_torque and load_inertia, a point mass on a lever:",
            f"# payload_kg = {PAYLOAD}",
            f"# lever_m = {LEVER}",
            "# Instead of omega_ref, in motor turns per second:",
            f"# speed_rps = {joint.nominal_speed:.10g}",
            "# The angle between the axis and the vertical; the gravity torque is multiplied by its sine:",
            "# gravity_angle_deg = 90.0",
            "",
        ]
    )


def described(joint: Joint) -> str:
    """Return a description of the joint: the default joint, or its differences from the default joint."""
    default = Joint()
    other = {name: getattr(joint, name) for name in FIELDS if getattr(joint, name) != getattr(default, name)}
    if not other:
        return "default joint"
    return "joint with " + ", ".join(f"{name} = {value:.6g}" for name, value in other.items())


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BenchError(f"joint {path} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise BenchError(f"joint {path} is not valid TOML: {error}") from error


def _joint(settings: Mapping[str, Any], where: str) -> Joint:
    known = {*FIELDS, *INSTEAD}
    for key, value in settings.items():
        if key not in known:
            raise BenchError(f"{where} has no parameter {key!r}{nearest(key, known)}")
        if not is_finite(value) or abs(value) >= LARGEST:
            raise BenchError(f"{where}: {key} must be a finite number, not {value!r}")
        for other in INSTEAD.get(key, ()):
            if other in settings:
                raise BenchError(f"{where} gives both {other} and {key}, which sets it; keep one of them")
    for key in ("payload_kg", "lever_m", "speed_rps"):
        require_positive(f"{where}: {key}", settings.get(key, 1.0))
    angle = settings.get("gravity_angle_deg", 90.0)
    if not 0 <= angle <= 90:
        raise BenchError(f"{where}: gravity_angle_deg must be from 0 (parallel to gravity) to 90, but it is {angle!r}")
    values = {key: float(value) for key, value in settings.items() if key in FIELDS}
    if {"payload_kg", "lever_m"} & settings.keys():
        mass, lever = settings.get("payload_kg", PAYLOAD), settings.get("lever_m", LEVER)
        values |= {"gravity_torque": mass * GRAVITY * lever, "load_inertia": mass * lever**2}
    if "speed_rps" in settings:
        values["omega_ref"] = 2 * pi * settings["speed_rps"]
    values["gravity_torque"] = values.get("gravity_torque", Joint().gravity_torque) * sin(radians(angle))
    try:
        return Joint(**values)
    except BenchError as error:
        raise BenchError(f"{where}: {str(error).removeprefix('Joint: ')}") from error
