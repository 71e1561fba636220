"""The parameters of the simulated robot joint (thesis chapter 4) and the gaps of its twenty datasets."""

from dataclasses import dataclass, fields
from math import isfinite, pi

from bench.errors import BenchError

LEVELS = 20
"""Number of backlash levels, and so of datasets."""

_MAY_BE_ZERO = {
    "gravity_torque",
    "damping",
    "integral_gain",
    "position_gain",
    "viscous_friction",
    "coulomb_friction",
}


@dataclass(frozen=True)
class Joint:
    """A motor that turns an unbalanced load through an elastic gear with backlash, under a position loop.

    The defaults are the thesis's test bench: they were identified from its published recordings, which they reproduce
    with 4 to 6.5 % of their standard deviation. A speed signal fixes only ratios of the mechanical parameters;
    the absolute scale is that of the 5 kg payload. Symbols are those of thesis Table 4.1 where it has them.

    Raises:
        BenchError: a parameter that is not finite or has the wrong sign.

    """

    gear_ratio: float = 40.0
    """N, motor turns per load turn."""

    omega_ref: float = 2 * pi * 100
    """Constant reference speed of the motor, rad/s (100 turns per second in the thesis)."""

    motor_inertia: float = 3.4e-5
    """Jm, kg m²."""

    load_inertia: float = 0.433
    """Jl, kg m²: a point mass of 5 kg at 0.294 m."""

    gravity_torque: float = 14.43
    """m g l, N m: the load's largest gravity torque. Zero for a joint whose axis is parallel to gravity."""

    stiffness: float = 2.25e4
    """Ks of the closed transmission, seen from the load, N m/rad."""

    damping: float = 23.0
    """Ds of the closed transmission, seen from the load, N m s/rad."""

    sharpness: float = 5.5e5
    """alpha of eq. (4.5), 1/rad: how abruptly the stiffness vanishes in the gap. Results converge from 3e5 upwards."""

    speed_gain: float = 0.0297
    """Kv, proportional gain of the speed loop, N m s/rad."""

    integral_gain: float = 254.0
    """ki, integral gain of the speed loop relative to Kv, 1/s."""

    position_gain: float = 31.0
    """kpp, proportional gain of the position loop, 1/s."""

    viscous_friction: float = 0.0
    """Viscous friction at the load, N m s/rad."""

    coulomb_friction: float = 0.0
    """Coulomb friction at the load, N m."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in _MAY_BE_ZERO:
                valid, rule = isfinite(value) and value >= 0, "finite and not negative"
            else:
                valid, rule = isfinite(value) and value > 0, "finite and positive"
            if not valid:
                raise BenchError(f"Joint: {field.name} must be {rule}, but it is {value!r}.")

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
    if level not in range(1, LEVELS + 1):
        raise BenchError(f"The backlash level must be a whole number from 1 to {LEVELS}, but it is {level!r}.")
    return (2 * level - 1) / 10_000
