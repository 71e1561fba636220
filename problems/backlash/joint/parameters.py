"""The parameters of the simulated robot joint (thesis chapter 4) and the gaps of its twenty datasets."""

from dataclasses import dataclass, field, fields
from math import pi
from typing import Any

from bench.errors import BenchError
from bench.numbers import is_finite
from problems.backlash.levels import LEVELS


def _quantity(default: float, meaning: str, *, may_be_zero: bool = False) -> Any:
    """Return a field with its meaning and unit, which joint files repeat, and whether it may be zero."""
    return field(default=default, metadata={"meaning": meaning, "may_be_zero": may_be_zero})


@dataclass(frozen=True)
class Joint:
    """A motor that turns an unbalanced load through an elastic gear with backlash, under a position loop.

    The defaults are the thesis's test bench: they were identified from its published recordings and reproduce these
    with an error of 4 to 6.5 % of their standard deviation. A speed signal fixes only ratios of the mechanical
    parameters; the absolute scale is that of the 5 kg payload. Symbols are those of thesis Table 4.1 where it has them.

    Raises:
        BenchError: a parameter that is not a finite number or has the wrong sign.
    """

    gear_ratio: float = _quantity(40.0, "N, motor turns per load turn")
    omega_ref: float = _quantity(2 * pi * 100, "constant reference speed of the motor, rad/s (2 pi times the rps)")
    motor_inertia: float = _quantity(3.4e-5, "Jm, kg m²")
    load_inertia: float = _quantity(0.433, "Jl, kg m²; 0.433 is a point mass of 5 kg at 0.294 m")
    gravity_torque: float = _quantity(
        14.43, "m g l, the load's largest gravity torque, N m; 0 for an axis parallel to gravity", may_be_zero=True
    )
    stiffness: float = _quantity(2.25e4, "Ks of the closed transmission, seen from the load, N m/rad")
    damping: float = _quantity(23.0, "Ds of the closed transmission, seen from the load, N m s/rad", may_be_zero=True)
    sharpness: float = _quantity(
        5.5e5, "alpha of eq. 4.5, 1/rad: how abruptly the stiffness vanishes in the gap; converged from 3e5 upwards"
    )
    speed_gain: float = _quantity(0.0297, "Kv, proportional gain of the speed loop, N m s/rad")
    integral_gain: float = _quantity(254.0, "ki, integral gain of the speed loop relative to Kv, 1/s", may_be_zero=True)
    position_gain: float = _quantity(31.0, "kpp, proportional gain of the position loop, 1/s", may_be_zero=True)
    viscous_friction: float = _quantity(0.0, "viscous friction at the load, N m s/rad", may_be_zero=True)
    coulomb_friction: float = _quantity(0.0, "Coulomb friction at the load, N m", may_be_zero=True)

    def __post_init__(self) -> None:
        for each in fields(self):
            value, may_be_zero = getattr(self, each.name), each.metadata["may_be_zero"]
            if not is_finite(value) or value < 0 or (value == 0 and not may_be_zero):
                rule = "finite and not negative" if may_be_zero else "finite and positive"
                raise BenchError(f"Joint: {each.name} must be {rule}, but it is {value!r}.")

    @property
    def nominal_speed(self) -> float:
        """The motor's reference speed in turns per second (rps)."""
        return self.omega_ref / (2 * pi)

    @property
    def turn(self) -> float:
        """The duration of one load turn, s: the period Tf of the disturbance (0.4 s in the thesis)."""
        return 2 * pi * self.gear_ratio / self.omega_ref


def half_gap(level: int) -> float:
    """Return the half-gap delta in rad of backlash level 1 to 20: 0.0001, 0.0003, …, 0.0039.

    The published datasets are numbered by the same level; thesis section 4.4 uses levels 2 to 11.

    Raises:
        BenchError: a level that is not a whole number from 1 to 20.
    """
    if level not in LEVELS:
        raise BenchError(f"The backlash level must be a whole number from 1 to {LEVELS[-1]}, but it is {level!r}.")
    return (2 * level - 1) / 10_000
