"""The parameters of the simulated robot joint (thesis chapter 4), their TOML files, and the gaps of its datasets."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import inf, pi, radians, sin
from pathlib import Path

from bench.contract.numbers import is_finite, require_positive
from bench.helpers import JsonObject, parse_toml, read_text
from bench.helpers.errors import BenchError, nearest
from problems.backlash import LEVELS

GRAVITY = 9.80665  # standard gravity, m/s²
LARGEST = 1e100  # larger numbers are no property of a joint, and a float cannot hold their cube

# kg and m; the point mass that makes the default joint's gravity torque and load inertia to within 3e-4 of each
PAYLOAD, LEVER = 5.0, 0.2943


def _quantity(default: float, meaning: str, *, may_be_zero: bool = False) -> float:
    """Return a field with its meaning and unit, which joint files repeat, and whether it may be zero."""
    return field(default=default, metadata={"meaning": meaning, "may_be_zero": may_be_zero})


@dataclass(frozen=True)
class Drive:
    """The motor, and the position loop around a PI speed loop that controls it."""

    motor_inertia: float = _quantity(3.4e-5, "Jm, kg m²")
    torque_constant: float = _quantity(
        1.0, "the motor's torque for a current of 1 A, N m/A; it scales the current alone"
    )
    omega_ref: float = _quantity(2 * pi * 100, "constant reference speed of the motor, rad/s (2 pi times the rps)")
    speed_gain: float = _quantity(0.0297, "Kv, proportional gain of the speed loop, N m s/rad")
    integral_gain: float = _quantity(254.0, "ki, integral gain of the speed loop relative to Kv, 1/s", may_be_zero=True)
    position_gain: float = _quantity(31.0, "kpp, proportional gain of the position loop, 1/s", may_be_zero=True)


@dataclass(frozen=True)
class Gear:
    """The elastic transmission with backlash between motor and load (eqs. 4.1 to 4.6)."""

    gear_ratio: float = _quantity(40.0, "N, motor turns per load turn")
    stiffness: float = _quantity(2.25e4, "Ks of the closed transmission, seen from the load, N m/rad")
    damping: float = _quantity(23.0, "Ds of the closed transmission, seen from the load, N m s/rad", may_be_zero=True)
    sharpness: float = _quantity(
        5.5e5, "alpha of eq. 4.5, 1/rad: how abruptly the stiffness vanishes in the gap; converged from 3e5 upwards"
    )


@dataclass(frozen=True)
class Load:
    """The unbalanced load and its friction."""

    load_inertia: float = _quantity(0.433, "Jl, kg m²; 0.433 is a point mass of 5 kg at 0.294 m")
    gravity_torque: float = _quantity(
        14.43, "m g l, the load's largest gravity torque, N m; 0 for an axis parallel to gravity", may_be_zero=True
    )
    viscous_friction: float = _quantity(0.0, "viscous friction at the load, N m s/rad", may_be_zero=True)
    coulomb_friction: float = _quantity(0.0, "Coulomb friction at the load, N m", may_be_zero=True)


FIELDS = {field.name: field for part in (Drive, Gear, Load) for field in fields(part)}
ORDER = (  # of the parameters in a joint's file
    "gear_ratio", "omega_ref", "motor_inertia", "load_inertia", "gravity_torque", "stiffness", "damping", "sharpness",
    "speed_gain", "integral_gain", "position_gain", "viscous_friction", "coulomb_friction", "torque_constant",
)  # fmt: skip


@dataclass(frozen=True)
class Joint:
    """A motor that turns an unbalanced load through an elastic gear with backlash, under a position loop.

    The defaults are the thesis's test bench: they were identified from its published recordings and reproduce these
    with an error of 4 to 6.5% of their standard deviation. A speed signal fixes only ratios of the mechanical
    parameters; the absolute scale is that of the 5 kg payload. Symbols are those of thesis Table 4.1 where it has them.

    Raises:
        BenchError: a parameter that is not a finite number or has the wrong sign.
    """

    drive: Drive = Drive()
    gear: Gear = Gear()
    load: Load = Load()

    def __post_init__(self) -> None:
        if [type(part) for part in (self.drive, self.gear, self.load)] != [Drive, Gear, Load]:
            raise BenchError("Joint: its parts are a Drive, a Gear and a Load, in this order.")
        for name, value in self.parameters.items():
            may_be_zero = FIELDS[name].metadata["may_be_zero"]
            if not is_finite(value) or value < 0 or (value == 0 and not may_be_zero):
                rule = "finite and not negative" if may_be_zero else "finite and positive"
                raise BenchError(f"Joint: {name} must be {rule}, but it is {value!r}.")

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters of all parts by name, in the order of a joint's file."""
        values = vars(self.drive) | vars(self.gear) | vars(self.load)
        return {name: values[name] for name in ORDER}

    @property
    def nominal_speed(self) -> float:
        """The motor's reference speed in turns per second (rps)."""
        return self.drive.omega_ref / (2 * pi)

    @property
    def turn(self) -> float:
        """The duration of one load turn, s: the period Tf of the disturbance (0.4 s in the thesis)."""
        return 2 * pi * self.gear.gear_ratio / self.drive.omega_ref

    @property
    def friction(self) -> float:
        """The friction at the load at the reference speed, as a part of gravity's torque; from 1 on no gap opens."""
        torque = self.load.coulomb_friction + self.load.viscous_friction * self.drive.omega_ref / self.gear.gear_ratio
        return torque / self.load.gravity_torque if self.load.gravity_torque else inf


def half_gap(level: int) -> float:
    """Return the half-gap delta in rad of backlash level 1 to 20: 0.0001, 0.0003, …, 0.0039.

    The published datasets are numbered by the same level; thesis section 4.4 uses levels 2 to 11.

    Raises:
        BenchError: a level that is not a whole number from 1 to 20.
    """
    if level not in LEVELS:
        raise BenchError(f"The backlash level must be a whole number from 1 to {LEVELS[-1]}, but it is {level!r}.")
    return (2 * level - 1) / 10_000


DEFAULT = Joint()

# Keys that a file may give instead of the joint's own parameters, and the parameters that each key sets.
INSTEAD = {
    "payload_kg": ("gravity_torque", "load_inertia"),
    "lever_m": ("gravity_torque", "load_inertia"),
    "speed_rps": ("omega_ref",),
    "gravity_angle_deg": (),
}


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
    replaced = {key: value for key, value in options.items() if value is not None}
    where = "the joint" if path is None else f"joint {path}"
    settings = read_toml(path, where) if path is not None else {}
    for key in replaced:
        for parameter in INSTEAD.get(key, ()):
            settings.pop(parameter, None)
    settings |= replaced
    allowed = {*FIELDS, *INSTEAD}
    for key, value in settings.items():
        if key not in allowed:
            raise BenchError(f"{where} has no parameter {key!r}{nearest(key, allowed)}")
        if not is_finite(value) or abs(value) >= LARGEST:
            raise BenchError(f"{where}: {key} must be a finite number, not {value!r}")
        for parameter in INSTEAD.get(key, ()):
            if parameter in settings:
                raise BenchError(f"{where} gives both {parameter} and {key}, which sets it; keep one of them")
    for key in ("payload_kg", "lever_m", "speed_rps"):
        require_positive(f"{where}: {key}", settings.get(key, 1.0))
    angle = settings.get("gravity_angle_deg", 90.0)
    if not 0 <= angle <= 90:
        raise BenchError(f"{where}: gravity_angle_deg must be from 0 (parallel to gravity) to 90, but it is {angle!r}")
    values = DEFAULT.parameters | {key: float(value) for key, value in settings.items() if key in FIELDS}
    if {"payload_kg", "lever_m"} & settings.keys():
        mass, lever = settings.get("payload_kg", PAYLOAD), settings.get("lever_m", LEVER)
        values |= {"gravity_torque": mass * GRAVITY * lever, "load_inertia": mass * lever**2}
    if "speed_rps" in settings:
        values["omega_ref"] = 2 * pi * settings["speed_rps"]
    values["gravity_torque"] *= sin(radians(angle))
    drive, gear, load = ({each.name: values[each.name] for each in fields(part)} for part in (Drive, Gear, Load))
    try:
        return Joint(Drive(**drive), Gear(**gear), Load(**load))
    except BenchError as error:
        raise BenchError(f"{where}: {str(error).removeprefix('Joint: ')}") from error


def joint_text(joint: Joint) -> str:
    """Return the text of a TOML file with all of the joint's parameters, their meanings and units, for editing."""
    lines = {name: f"{name} = {float(value)!r}" for name, value in joint.parameters.items()}
    width = max(map(len, lines.values()))
    rows = "\n".join(f"{line:{width}}  # {FIELDS[name].metadata['meaning']}" for name, line in lines.items())
    return f"""\
# A robot joint for 'bench simulate --joint' and 'bench calibrate --joint', in SI units.
# A line that is left out has the value of the thesis's test bench.
{rows}

# Instead of gravity_torque and load_inertia, a point mass on a lever:
# payload_kg = {PAYLOAD}
# lever_m = {LEVER}
# Instead of omega_ref, in motor turns per second:
# speed_rps = {joint.nominal_speed:.10g}
# The angle between the axis and the vertical; the gravity torque is multiplied by its sine:
# gravity_angle_deg = 90.0
"""


def described(joint: Joint) -> str:
    """Return a description of the joint: the default joint, or its differences from the default joint."""
    differing = {name: value for name, value in joint.parameters.items() if value != DEFAULT.parameters[name]}
    if not differing:
        return "default joint"
    return "joint with " + ", ".join(f"{name} = {value:.6g}" for name, value in differing.items())


def read_toml(path: str | Path, where: str) -> JsonObject:
    """Return the content of a TOML file; raises BenchError, which begins with ``where``, if it cannot be read."""
    try:
        return parse_toml(read_text(Path(path)))
    except OSError as error:
        raise BenchError(f"{where} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise BenchError(f"{where} is not valid TOML: {error}") from error
