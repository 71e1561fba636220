"""Convert an amplitude to a backlash by the mapping delta = f(A) of section 4.4, made with the simulator.

>>> from problems.backlash.joint import half_gap, load_joint
>>> made = calibrate(load_joint("joint.toml"), [half_gap(level) for level in range(2, 12)])
>>> made.save("calibration.toml")
>>> load_calibration("calibration.toml").backlash(42.0)    # rpm -> rad

The amplitude is the peak of the disturbance. The strength of a fit differs from it by the fit's response to a joint's
own disturbances, which can be simulated as well: see :mod:`problems.backlash.sensor.response`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import tomli_w
from scipy.interpolate import PchipInterpolator

from bench.contract.numbers import is_finite, require_positive
from bench.contract.typing import Floats
from bench.helpers import JsonObject, replacing
from bench.helpers.errors import BenchError, nearest
from problems.backlash.joint import Joint
from problems.backlash.joint.parameters import described, read_toml
from problems.backlash.signature.datasets import simulated

# The thesis's own cubic of levels 2 to 11, in 1e-6 rad by powers of the amplitude in rpm, the third one first.
EQUATION_4_7 = (-0.0018, 0.4323, 9.2524, 34.0313)
EQUATION_4_7_RANGE = (60 * 0.2769, 60 * 1.1385)  # rpm; the amplitudes of those levels in Table 7.3
MOST_GAPS = 100
FEWEST = 2  # pairs
# The largest relative difference of a recording's gear ratio and motor speed from the calibration's. A simulated joint
# that differs by 1% in either is estimated with an error of at most 1e-4 rad, half of the accuracy asked in section
# 7.2.1; one that differs by 2%, by up to 3.5e-4 rad ('python validation/sensor.py --elsewhere').
NEAR = 0.01
LISTS = ("amplitude_rpm", "half_gap_rad", "fitted_rpm", "scatter_rpm", "ringing_hz", "decay_per_s", "ripple_rpm")
ENTRIES = {
    "name": "name", "amplitude_rpm": "amplitude", "half_gap_rad": "half_gap", "gear_ratio": "gear_ratio",
    "speed_rps": "speed_rps", "friction": "friction", "fitted_rpm": "fitted", "scatter_rpm": "scatter",
    "ringing_hz": "ringing", "decay_per_s": "decay", "ripple_rpm": "ripple",
}  # fmt: skip
"""The entries of a calibration's file, and the attributes that hold them; those of ``LISTS`` are lists of numbers."""

ALIKE = 0.08  # the largest difference of two frictions, as parts of gravity's torque, that counts as none
# What a recording shows of its joint's load, stiffness and controller, in words, and the largest relative difference
# that counts as none: noise changes the ringing by up to 1.5%, and 3 to 5% in it go with up to 20% in the half-gap.
SHOWN = {
    "ringing": ("the impacts ring at {:.3g} Hz, the calibration's at {:.3g}", 0.02),
    "decay": ("they decay by {:.3g} a second, the calibration's by {:.3g}", 0.3),
    "ripple": ("the load's ripple is {:.3g} rpm, the calibration's {:.3g}", 0.2),
}
FAINTEST = 0.06  # rpm; one count of a 19-bit encoder in a speed sampled at 500 Hz (60 x 500 / 2**19)


@dataclass(frozen=True, eq=False)
class Calibration:
    """A growing curve through pairs of amplitude and half-gap, a shape-preserving interpolation.

    Section 4.4 has a least-squares cubic instead (``coefficients``). The thesis's own was fitted to small gaps and is
    2.6e-4 rad off at the largest gap of its datasets.

    Attributes:
        amplitude: (m,) expected amplitudes in rpm, increasing.
        half_gap: (m,) rad, increasing.
        name: the joint of this calibration and the calibration's origin.
        fitted: (m,) rpm, increasing: the mean strength of the fits to a half-gap's recordings; None if unknown.
        scatter: (m,) rpm: the standard deviation of those strengths over the positions of the samples; None likewise.
        gear_ratio: motor turns a load turn of its joint; None if unknown.
        speed_rps: the motor speed at which it holds, rps; None if unknown.
        friction: the friction at the load as a part of gravity's torque; None if unknown.
        shown: what those recordings show besides, (m,) each, as far as it is known: "ringing", the mean frequency of
            the impacts in Hz; "decay", the mean damping of the fits in 1/s; "ripple", the mean first harmonic of the
            load turn in rpm.

    Raises:
        BenchError: for too few pairs, pairs that do not increase, and fitted amplitudes that do not grow with the
            half-gap or have no scatter.
    """

    amplitude: Floats
    half_gap: Floats
    name: str = ""
    fitted: Floats | None = None
    scatter: Floats | None = None
    gear_ratio: float | None = None
    speed_rps: float | None = None
    friction: float | None = None
    shown: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.amplitude.shape != self.half_gap.shape or self.amplitude.ndim != 1:
            raise BenchError(
                f"a calibration pairs each amplitude with a half-gap, but there are {self.amplitude.size} amplitudes "
                f"and {self.half_gap.size} half-gaps"
            )
        if len(self.amplitude) < FEWEST:
            raise BenchError(
                f"a calibration needs at least {FEWEST} pairs of amplitude and half-gap, not {len(self.amplitude)}"
            )
        self._check_growing(self.half_gap, "half-gap")
        self._check_growing(self.amplitude, "amplitude")
        for name in ("gear_ratio", "speed_rps"):
            if (value := getattr(self, name)) is not None:
                require_positive(f"the {name} of a calibration", value)
        if self.friction is not None and not (is_finite(self.friction) and self.friction >= 0):
            raise BenchError(f"the friction of a calibration must be finite and not negative, not {self.friction!r}")
        self._check_fits()

    @property
    def range(self) -> tuple[float, float]:
        """The smallest and the largest amplitude in rpm that this calibration covers."""
        return float(self.amplitude[0]), float(self.amplitude[-1])

    def backlash(self, amplitude: float) -> float:
        """Return the half-gap delta in rad of an amplitude in rpm; NaN outside the simulated range."""
        return float(self._curve(abs(amplitude)))

    def expected(self, fitted: float) -> float:
        """Return the expected amplitude in rpm for a fit's strength in rpm; NaN outside the fitted range.

        A calibration without fits returns the strength itself.
        """
        return fitted if self._response is None else float(self._response(fitted))

    def relative_scatter(self, fitted: float) -> float:
        """Return the standard deviation of fits at a fit's strength in rpm, relative to it; 0 if unknown.

        Outside the fitted range the value of the nearest end is returned.
        """
        if self.fitted is None or self.scatter is None:
            return 0.0
        return float(np.interp(fitted, self.fitted, self.scatter / self.fitted))

    def differences(self, speed_rps: float, gear_ratio: float | None) -> list[str]:
        """Return in words how the motor speed and gear ratio (None if unknown) of a recording differ from its own.

        The disturbance and its fit depend on both, so this calibration holds for no recording that differs.
        """
        differing = []
        if gear_ratio is not None and self.gear_ratio is not None and not _near(gear_ratio, self.gear_ratio):
            differing.append(f"a gear ratio of {gear_ratio:.4g}, not {self.gear_ratio:g}")
        if self.speed_rps is not None and not _near(abs(speed_rps), self.speed_rps):
            differing.append(f"a motor speed of {abs(speed_rps):.4g} rps, not {self.speed_rps:g}")
        return differing

    def other_joint(self, fitted: float, friction: float, shown: Mapping[str, float], wider: float = 1.0) -> str:
        """Return in a sentence what a recording shows of another joint than this one; "" for nothing.

        Args:
            fitted: the strength of the fit in rpm, at which the values of ``SHOWN`` are compared.
            friction: of the recording, as a part of gravity's torque.
            shown: the values of ``SHOWN`` in the recording, NaN for an unknown one.
            wider: a factor of their largest differences, for a noisy recording.
        """
        differences = []
        if self.friction is not None and abs(friction - self.friction) > ALIKE:
            differences.append(
                f"the impacts are as unevenly apart as with friction of {friction:.0%} of gravity's torque, and the "
                f"calibration has {self.friction:.0%}"
            )
        for name, (words, alike) in SHOWN.items():
            if self.fitted is None or (own := self.shown.get(name)) is None:
                continue
            usual = float(np.interp(fitted, self.fitted, own, left=np.nan, right=np.nan))
            if abs(shown[name] / usual - 1) > wider * alike:
                differences.append(words.format(shown[name], usual))
        if not differences:
            return ""
        return (
            f"{'; '.join(differences)}; calibrate this joint as it is (bench calibrate --joint), and give --calibration"
        )

    @property
    def coefficients(self) -> Floats:
        """(4,) of the least-squares cubic in the form of eq. 4.7: 1e-6 rad by powers of the amplitude in rpm."""
        return np.polyfit(self.amplitude, 1e6 * self.half_gap, 3)

    @property
    def deviation(self) -> float:
        """The largest relative deviation from eq. 4.7 within the amplitudes of that equation; NaN for none of them."""
        low, high = np.clip(EQUATION_4_7_RANGE, *self.range)
        if low == high:
            return np.nan
        between = np.linspace(low, high, 1001)
        thesis = 1e-6 * np.polyval(EQUATION_4_7, between)
        return float(np.max(np.abs([self.backlash(a) for a in between] / thesis - 1)))

    def formula(self) -> str:
        """Return the cubic in the form of eq. 4.7 as plain text."""
        return f"delta = 1e-6 ({polynomial(self.coefficients)}) rad, A in rpm"

    def save(self, path: str | Path, *, command: str = "bench calibrate") -> None:
        """Write the calibration as TOML, for :func:`load_calibration`; raises BenchError if it cannot be written.

        The file begins with the ``command`` that reproduces it.
        """
        values = {**vars(self), **self.shown}
        known = {key: value for key, name in ENTRIES.items() if (value := values.get(name)) is not None}
        content = {key: value.tolist() if key in LISTS else value for key, value in known.items()}
        with replacing(Path(path)) as temporary:
            temporary.write_text(
                f"# {command}\n"
                "# The half-gap of a joint by the amplitude of the disturbance it makes.\n"
                f"{tomli_w.dumps(content)}",
                encoding="utf-8",
            )

    def _check_growing(self, values: Floats, what: str) -> None:
        """Raise BenchError for (m,) values that are not finite, are negative, or do not grow."""
        if not (np.isfinite(values).all() and values[0] >= 0):
            raise BenchError(f"every {what} of a calibration must be finite and not negative")
        if (np.diff(values) <= 0).any():
            at = int(np.argmax(np.diff(values) <= 0))
            fall = f"falls by {1 - values[at + 1] / values[at]:.0%}" if values[at + 1] < values[at] else "stays"
            raise BenchError(
                f"no calibration: after the half-gap of {self.half_gap[at]:g} rad the {what} does not grow but {fall}; "
                f"{self._growing_gaps(values)}"
            )

    def _growing_gaps(self, values: Floats) -> str:
        """Return the advice to take the smallest half-gaps: as many as grow and whose values no larger one has again.

        A larger half-gap then falls outside the calibration, where otherwise it would be taken for a smaller one.
        """
        later = np.append(np.minimum.accumulate(values[::-1])[::-1][1:], np.inf)  # the smallest value after each
        count = int(np.argmin(np.append(values < later, False)))
        if count < FEWEST or (np.diff(self.half_gap[:count]) <= 0).any():
            return "take half-gaps over which it grows"
        last = self.half_gap[count - 1]
        return (
            f"take half-gaps up to {last:g} rad, above which it is never so small again: "
            f"--gaps {self.half_gap[0]:g}:{last:g}:{count}"
        )

    def _check_fits(self) -> None:
        """Raise BenchError for fits of the wrong shape, or without a scatter."""
        for name, values in self.shown.items():
            if not (values.shape == self.half_gap.shape and np.isfinite(values).all() and values.min() > 0):
                raise BenchError(f"a calibration has a finite and positive {name} of each half-gap")
        if self.fitted is None and self.scatter is None:
            return
        shapes = {None if values is None else values.shape for values in (self.fitted, self.scatter, self.half_gap)}
        if self.fitted is None or self.scatter is None or len(shapes) > 1:
            raise BenchError(
                "fitted amplitudes and their scatter come together, one of each a half-gap; "
                "'bench calibrate' makes them"
            )
        self._check_growing(self.fitted, "fitted amplitude")
        if not (np.isfinite(self.scatter).all() and (self.scatter >= 0).all() and self.fitted[0] > 0):
            raise BenchError(
                "every scatter of a calibration must be finite and not negative, and every fitted amplitude positive"
            )

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.amplitude, self.half_gap, extrapolate=False)

    @cached_property
    def _response(self) -> PchipInterpolator | None:
        return None if self.fitted is None else PchipInterpolator(self.fitted, self.amplitude, extrapolate=False)


def _near(value: float, calibrated: float) -> bool:
    return abs(value / calibrated - 1) <= NEAR


def polynomial(coefficients: Sequence[float] | Floats) -> str:
    """Return a cubic in A with four decimals, as eq. 4.7 is printed."""
    first, *lower = coefficients
    powers = (" A^2", " A", "")
    terms = (f" {'-' if c < 0 else '+'} {abs(c):.4f}{power}" for c, power in zip(lower, powers, strict=True))
    return f"{first:.4f} A^3{''.join(terms)}"


def calibrate(joint: Joint, half_gaps: Sequence[float]) -> Calibration:
    """Return the calibration of a joint by a simulation of each of 2 to 100 half-gaps in rad.

    Raises:
        BenchError: for too few or too many half-gaps, half-gaps that do not increase, and a joint whose disturbance is
            too small to measure or does not grow with the gap.
    """
    if not 2 <= len(half_gaps) <= MOST_GAPS:
        raise BenchError(f"a calibration takes from 2 to {MOST_GAPS} simulated half-gaps, not {len(half_gaps)}")
    if joint.load.gravity_torque and joint.friction >= 1:
        raise BenchError(
            f"no calibration: friction of {joint.friction:.0%} of gravity's torque keeps the gears on one flank, so no "
            "gap opens and none can be seen; turn the joint slower, or load it"
        )
    gaps = np.array(half_gaps, dtype=np.float64)
    amplitude = 60 * np.array([simulated(gap, joint).peak for gap in gaps.tolist()], dtype=np.float64)
    if amplitude.max() < FAINTEST:
        raise BenchError(
            f"no calibration: the disturbance of the {described(joint)} stays below {FAINTEST} rpm whatever the "
            "half-gap; without gravity about its axis nothing opens the gap (robot joint 1), so turn it or load it"
        )
    extent = f"half-gaps {gaps.min():g} … {gaps.max():g} rad"
    return Calibration(
        amplitude, gaps, f"{described(joint)}, simulated, {extent}",
        gear_ratio=joint.gear.gear_ratio, speed_rps=joint.nominal_speed, friction=joint.friction,
    )  # fmt: skip


@cache
def default_calibration() -> Calibration:
    """Return the calibration of the default joint, from no gap to beyond level 20, whose fits scatter to both sides.

    Its lower end is the joint's own disturbance without backlash; above its upper one the motion is irregular. It is of
    the thesis's levels and is stored, as every trial needs it.
    """
    return load_calibration(Path(__file__).with_name("default_calibration.toml"))


@cache
def sensor_calibration() -> Calibration:
    """Return the calibration of the default joint with the response of the fits, for estimates from recordings."""
    return load_calibration(Path(__file__).with_name("sensor_calibration.toml"))


def load_calibration(path: str | Path) -> Calibration:
    """Return the calibration of a TOML file: its name, amplitudes in rpm and half-gaps in rad.

    What else 'bench calibrate' writes may be left out; recordings are not compared with what is.

    Raises:
        BenchError: for a file that cannot be read or is not a calibration.
    """
    where = f"calibration {path}"
    content: JsonObject = {"name": path, "amplitude_rpm": None, "half_gap_rad": None} | read_toml(path, where)
    for key in content:
        if key not in ENTRIES:
            raise BenchError(f"{where} has the unknown entry {key!r}{nearest(key, ENTRIES)}")
    content |= {key: _numbers(value, key, where) for key, value in content.items() if key in LISTS}
    content["name"] = str(content["name"])
    given = {ENTRIES[key]: value for key, value in content.items()}
    shown = {name: given.pop(name) for name in SHOWN if name in given}
    try:
        return Calibration(**given, shown=shown)
    except BenchError as error:
        raise BenchError(f"{where}: {error}") from error


def _numbers(values: object, key: str, where: str) -> Floats:
    if not isinstance(values, list) or any(
        isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e100 for value in values
    ):
        raise BenchError(f"{where}: {key} must be a list of numbers; 'bench calibrate --output' writes such files")
    return np.array(values, dtype=np.float64)
