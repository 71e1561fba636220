"""Simulate a joint that wears: one noisy recording a month, of a gap that grows by the three-phase wear curve.

For demonstrations and tests of monitoring, because no recordings of a real joint over years exist. The curve has the
textbook's shape: running-in, whose wear rate decays exponentially to a steady rate (Queener, Smith and Mitchell,
Transient wear of machine parts, Wear 8, 1965, 391-400; reviewed by Khonsari, Ghatrehsamani and Akbarzadeh, Wear
474-475, 2021, 203871, doi:10.1016/j.wear.2021.203871); steady wear in proportion to the distance travelled (Archard, J.
Appl. Phys. 24, 1953, 981-988, doi:10.1063/1.1721448); and accelerated wear at the end of life, for which there is no
agreed law: here its rate grows in proportion to the time since its onset. The share of each phase is a choice and was
not measured on a gear.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any, NamedTuple

import numpy as np

from bench.contract.numbers import is_finite
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.joint.parameters import Joint
from problems.backlash.joint.simulator import simulate, with_noise

MOST_MONTHS = 240
FIRST_YEAR = 2024
RUN_IN, STEADY, ACCELERATED = 0.15, 0.45, 0.40  # the share of each phase in the total wear
RUN_IN_TIME, ONSET = 0.05, 0.70  # the time constant of running-in, the onset of accelerated wear: parts of the life


class Month(NamedTuple):
    """A month's recording and the truth behind it.

    Attributes:
        name: the month, such as ``"2024-01"``.
        half_gap: delta in rad.
        peak: the true amplitude of the disturbance, rps, without noise.
        time: (n,) s, from 0.
        speed: (n,) motor speed with noise, rps.
    """

    name: str
    half_gap: float
    peak: float
    time: Floats
    speed: Floats


def wear(life: Floats) -> Floats:
    """Return the share of the total wear (n,) after a share of the life (n,), both from 0 to 1."""
    run_in = (1 - np.exp(-life / RUN_IN_TIME)) / (1 - np.exp(-1 / RUN_IN_TIME))
    accelerated = (np.maximum(life - ONSET, 0.0) / (1 - ONSET)) ** 2
    worn: Floats = RUN_IN * run_in + STEADY * life + ACCELERATED * accelerated
    return worn


def half_gaps(new: float, worn: float, months: int) -> Floats:
    """Return the half-gap in rad of each month, (months,), from ``new`` in the first to ``worn`` in the last.

    Raises:
        BenchError: for gaps that are negative or do not grow, and for months that are not from 2 to 240.
    """
    if months not in range(2, MOST_MONTHS + 1):
        raise BenchError(f"a wear curve takes from 2 to {MOST_MONTHS} months, not {months!r}")
    if not (is_finite(worn) and 0 <= new < worn):
        raise BenchError(f"a gap grows with wear, from at least 0 rad: from {new!r} to {worn!r} rad is no wear")
    return new + (worn - new) * wear(np.linspace(0.0, 1.0, months))


def monthly_recordings(
    joint: Joint,
    *,
    new: float,
    worn: float,
    months: int,
    noise: float,
    seed: int,
    start_angle: float | None = None,
    **options: Any,
) -> Iterator[Month]:
    """Yield a recording for each month, from January 2024 on.

    Noise and start of a month are drawn from the seed and the month's number alone, so that a longer curve begins
    with the same draws.

    Args:
        joint: the joint and its controller.
        new, worn: half-gap in the first and in the last month, rad.
        months: how many.
        noise: peak-to-peak value of the uniform white noise, rps (eqs. 7.1 and 7.2).
        seed: the seed of the noise and the start angles.
        start_angle: load angle at which every recording starts, rad; None draws it from half a load turn, because real
            recordings start anywhere (the thesis starts at one of the first 100 samples, section 7.3).
        **options: of :func:`problems.backlash.joint.simulate`.

    Raises:
        BenchError: as :func:`half_gaps` and those of :mod:`problems.backlash.joint.simulator`.
    """
    for number, gap in enumerate(half_gaps(new, worn, months)):
        rng = np.random.default_rng([seed, number])
        start = rng.uniform(0.0, pi)
        made = simulate(
            joint, half_gap=float(gap), start_angle=start if start_angle is None else start_angle, **options
        )
        name = f"{FIRST_YEAR + number // 12}-{number % 12 + 1:02d}"
        yield Month(name, float(gap), made.peak, made.time, with_noise(made.speed, noise, rng))
