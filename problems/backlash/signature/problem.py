"""The constrained signature fit as a problem (thesis sections 5.3.1, 7.1.1 and 7.2.2)."""

import copy
from collections.abc import Iterable
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np

from bench.contract.numbers import require_flag, require_positive, require_whole
from bench.contract.problem import Problem
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from problems.backlash.recordings import Recording
from problems.backlash.recordings.screen import screen_length, screen_sampling, screen_values
from problems.backlash.signature import kernel
from problems.backlash.signature.calibration import default_calibration
from problems.backlash.signature.model import OMEGA, T0, T1, T2, VARIABLES, A, box, signature

Unit = Literal["rps", "rpm"]

FACTOR = {"rps": 1.0, "rpm": 60.0}

TOLERANCE_RAD = 0.0002 / 2  # rad; half of Delta delta, the accuracy asked of a backlash estimate (section 7.2.1)
TOLERANCE_RPM = 3.8672 / 2  # rpm; half of Delta A, the accuracy on delta as an accuracy on A (section 7.2.3)
# A fit counts as having found the best fit if its RMSE exceeds the best by at most this share: on noisy recordings its
# |A| is then off by a few percent at most, and the next basins are much further away.
FOUND = 0.01


class Fit(NamedTuple):
    """A point (7,) and its RMSE, in the problem's unit."""

    x: Floats
    value: float


class SignatureFit(Problem):
    """Fit the backlash signature to a recording of motor speed by minimising the RMSE.

    The signal is the speed less its mean, as the thesis's swarms saw it, so v_t is the offset from the mean speed.
    Objective, A and v_t are in ``unit``; times are in s, tau in 1/s, omega in rad/s.

    Args:
        name: the name to store results under.
        recording: the signal, in rps, and the truth where it is known.
        period: T_f, the time of one load turn, in s.
        turns: n, the load turns that the signature spans.
        single: fit one oscillation instead of a train of them, for less than one load turn of a robot's wrist (section
            8.3); ``turns`` then has no meaning, and ``period`` limits T1 and T2 alone.
        unit: "rps", as the authors' notebook, or "rpm", as Table 7.2.
        amplitude_factor: A's bound in units of the half range; 1.0 in Table 7.1, 1.3 in the notebook.
        t0_turns: the load turns from the first sample on in which t0 may lie; None is the whole recording, as in
            Table 7.1. With a range, no optimum is known: the reference fit's first window begins within it, too.
        constrained: whether the thesis's constraints are constraints of the problem, so that only points that satisfy
            them are recorded, and a study's handling decides what optimizers see of others: ``repair`` is the thesis's
            capping rule. Without, as in the thesis's comparison, an optimizer may repair its points, or not.

    Attributes:
        expected: the expected ``amplitude_rpm`` and ``backlash_rad``, where they are known, each with half the width of
            its accuracy band.

    Raises:
        BenchError: for options out of range and a recording that is too short or too coarse for a load turn.
    """

    variables = VARIABLES
    repairs = True
    optimum_source = "a reference fit, found by an exhaustive search"

    def __init__(
        self,
        name: str,
        recording: Recording,
        *,
        period: float = 0.4,
        turns: int = 12,
        single: bool = False,
        unit: Unit = "rps",
        amplitude_factor: float = 1.3,
        t0_turns: float | None = None,
        constrained: bool = False,
    ) -> None:
        _check_options(name, period, turns, single, unit, amplitude_factor, t0_turns, constrained)
        _check_recording(name, recording, period, single=single)
        self._references: dict[bool, Fit] = {}
        self.name = name
        self.unit = unit
        self.measure = f"the RMSE of the fitted signature in {unit}"
        self.constrained = constrained
        self.period = float(period)
        self.time = recording.time
        self.mean_rps = float(recording.speed.mean())
        self.signal: Floats = (recording.speed - self.mean_rps) * FACTOR[unit]  # r(t), (eq. 5.1)
        expected = {}
        if recording.peak is not None:
            expected["amplitude_rpm"] = (60.0 * recording.peak, TOLERANCE_RPM)
        if recording.half_gap is not None:
            expected["backlash_rad"] = (recording.half_gap, TOLERANCE_RAD)
        self.expected = expected
        factor = float(amplitude_factor)
        self.lower, self.upper = box(self.time, self.signal, period=self.period, amplitude_factor=factor)
        if t0_turns is not None:
            self.upper[T0] = min(self.upper[T0], self.time[0] + float(t0_turns) * self.period)
        self._anywhere = t0_turns is None  # whether t0 may lie anywhere in the recording
        self.replicas = 1 if single else 2 * int(turns)  # oscillations of the train, two a load turn
        self.dt = recording.dt
        self._folded = self._fold(self.signal)

    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) RMSEs of (n, 7) points, in ``unit``."""
        values: Floats = kernel.evaluate(np.ascontiguousarray(x, dtype=np.float64), self._folded)
        return values

    def repair(self, x: Floats) -> Floats:
        """Return the (n, 7) points with every value capped at the limit it breaks (section 7.2.2)."""
        points = np.ascontiguousarray(x, dtype=np.float64)
        start, stop = self.time[0], self.time[-1]
        delay = min(self.period / 2, stop - start)  # a wrist's oscillation may be longer than its recording
        repaired: Floats = kernel.repair(points, self.lower, self.upper, start, stop, delay)
        return repaired

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, 4) violations, in s, of the constraints of section 7.2.2 at (n, 7) points; None without them.

        In eq. 3.5's names: T1 <= pi / (2 omega), T1 <= T2 <= T_d, and t0 <= max t - T2.
        """
        if not self.constrained:
            return None
        t0, omega, start, end = (x[:, index] for index in (T0, OMEGA, T1, T2))
        return np.stack(
            [start - np.pi / (2 * omega), start - end, end - self.period / 2, t0 - (self.time[-1] - end)], axis=1
        )

    @cached_property
    def optimum(self) -> float | None:  # type: ignore[override] # few callers need it, so it is computed on demand
        """The RMSE of the reference fit within the box, in ``unit``; the constraints leave no lower one."""
        return self.reference(constrained=self.constrained).value if self._anywhere else None

    @cached_property
    def repaired_optimum(self) -> float | None:  # type: ignore[override] # likewise
        """The RMSE of the reference fit under the constraints, in ``unit``, which repaired points satisfy."""
        return self.reference(constrained=True).value if self._anywhere else None

    def reference(self, *, constrained: bool = False) -> Fit:
        """Return the reference fit, the best within the box or, with ``constrained``, under the constraints too.

        See :mod:`problems.backlash.signature.reference`; the first call takes up to two seconds.
        """
        from problems.backlash.signature.reference import best_fit

        if constrained not in self._references:
            x = best_fit(self._folded, self.lower, self.upper, constrained=constrained)
            self._references[constrained] = Fit(x, float(self.evaluate(x[None])[0]))
        return self._references[constrained]

    def beside(self, speed: Floats) -> "SignatureFit":
        """Return the same problem, with the same box, for another signal (N,) in ``unit``."""
        problem = copy.copy(self)
        problem.signal, problem._references = speed, {}
        problem._folded = problem._fold(speed)
        return problem

    def _fold(self, signal: Floats) -> kernel.Folded:
        return kernel.fold(signal, start=float(self.time[0]), dt=self.dt, period=self.period, replicas=self.replicas)

    def near(self, x: Floats, signals: Iterable[Floats]) -> Floats:
        """Return the (m, 7) best fits near a point (7,) to m signals (N,) like the problem's own, in ``unit``."""
        from problems.backlash.signature.refits import fits_near

        fits = fits_near(self._folded, signals, self.lower, self.upper, x)
        return np.array(list(fits)).reshape(-1, len(x))

    def model(self, x: Floats) -> Floats:
        """Return the (N,) signature of a (7,) point, about the recording's mean speed; in ``unit``."""
        return signature(self.time, x, period=self.period, replicas=self.replicas)

    def describe(self, x: Floats) -> dict[str, float]:
        """Return the amplitude |A| in rpm, its error against the expected one, and the half-gap delta in rad.

        The half-gap is by the calibration of the thesis's joint, hence not of a single oscillation, a wrist's.
        The sign of A has no meaning: (A, t0) and (-A, t0 + T_d) describe the same train except in its first half turn.
        """
        amplitude = abs(float(x[A])) * 60.0 / FACTOR[self.unit]
        metrics = {"amplitude_rpm": amplitude}
        if "amplitude_rpm" in self.expected:
            metrics["amplitude_error_rpm"] = amplitude - self.expected["amplitude_rpm"][0]
        if self.replicas > 1:
            metrics["backlash_rad"] = default_calibration().backlash(amplitude)
        return metrics


def _check_recording(name: str, recording: Recording, period: float, *, single: bool) -> None:
    """Raise BenchError for a recording to which no signature can be fitted."""
    try:
        screen_values(recording)
        screen_sampling(recording, period)
        if not single:
            screen_length(recording, period)
        if np.abs(recording.speed).max() > 1e6:
            raise BenchError("no motor has a speed of more than 1e6 rps; give the speed in rps")
    except BenchError as error:
        raise BenchError(f"problem {name!r}: {error}") from error


def _check_options(
    name: str, period: float, turns: int, single: bool, unit: str, amplitude_factor: float, t0_turns: float | None,
    constrained: bool,
) -> None:  # fmt: skip
    """Raise BenchError for an option of the wrong type or out of range."""
    if unit not in get_args(Unit):
        raise BenchError(f"problem {name!r}: unit must be 'rps' or 'rpm', not {unit!r}")
    require_whole(f"problem {name!r}: turns", turns, 1, 100_000)
    for option, flag in (("single", single), ("constrained", constrained)):
        require_flag(f"problem {name!r}: {option}", flag)
    positive = {
        "period": period,
        "amplitude_factor": amplitude_factor,
        "t0_turns": 1.0 if t0_turns is None else t0_turns,
    }
    for option, value in positive.items():
        require_positive(f"problem {name!r}: {option}", value, 1e6)
