"""The contract of a problem, and a problem from a user's own function."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.contract.typing import Flags, Floats
from bench.helpers.errors import BenchError, StopRun


class Problem(ABC):
    """A box-bounded single-objective minimisation problem.

    A subclass sets the attributes below and implements :meth:`evaluate`. It must be pure (no state changes between
    calls) and picklable or reloadable by name, because trials run in worker processes. Every method gets an array of
    its own, in which it may compute.

    Attributes:
        name: the name under which the problem is loaded and stored, such as ``"signature-12"``.
        variables: the d names of the search variables, such as ``("A", "t0", …)``.
        lower: (d,) float64, the lower end of the box. When a problem is loaded, the harness replaces ``lower``,
            ``upper`` and ``integer`` by copies that cannot be written to (:func:`with_own_box`).
        upper: (d,) float64, the upper end of the box.
        optimum: the best known objective value, or None where none is known.
        repaired_optimum: the best known value of the points that :meth:`repair` returns, where the optimum itself may
            be none of them; None (default) where repaired points can reach the optimum. Reports count the regret and
            the targets of an optimizer that repairs its points from this value.
        optimum_point: (d,) a point of the box at which the optimum is reached, or None where none is claimed (default);
            no optimizer sees it, ``bench check`` evaluates it.
        initial_points: (k, d) points of the box that are known before a search, which begins with them; None (default)
            without any.
        optimum_source: where it is from, as the methods of a report say it, such as ``"an exhaustive search"``.
        measure: what the objective value is, with its unit, likewise, such as ``"the RMSE of the fit in rpm"``.
        expected: the true value and the acceptable error of domain metrics, by their names in :meth:`describe`, such as
            ``{"amplitude_rpm": (140.2, 1.93)}``; reports draw them.
        features: what kind of problem it is, by which reports can group problems, such as ``{"suite": "bbob",
            "function": "f08", "instance": 1, "group": "low or moderate conditioning"}``; empty where nothing is known.
            ``sweep`` names what problems with the same value are steps of: they are not independent, and reports say so
            next to tests across them.
        repairs: whether the points that :meth:`repair` returns violate no constraint.
        integer: (d,) bool, the variables that are whole numbers, or None without any (default). The harness rounds them
            before a point is evaluated and recorded, so :meth:`evaluate` gets whole numbers; their bounds must be such.
        compiles: whether the first evaluation compiles code, or loads compiled code: each job of a run then evaluates
            a point before its trials. None (default): it is taken to where numba is imported once it is loaded.
        joint: whether :meth:`evaluate` finds the violations together with the value, as a simulation does, and keeps
            those of its last call for :meth:`violations` to return. How many they are need not be known before.
        by_point: whether :meth:`evaluate` computes one point after the other, so that a batch saves nothing. Where a
            study goes on after a point that fails, no other point of its batch is then computed twice.
        noisy: whether :meth:`evaluate` takes a random generator, ``evaluate(x, rng)``, and returns what is observed;
            :meth:`noiseless` then returns the true values. An optimizer sees the former, the latter are recorded.
    """

    name: str
    variables: tuple[str, ...]
    lower: Floats
    upper: Floats
    optimum: float | None = None
    repaired_optimum: float | None = None
    optimum_point: Floats | None = None
    initial_points: Floats | None = None
    optimum_source: str = ""
    measure: str = ""
    expected: Mapping[str, tuple[float, float]] = MappingProxyType({})
    features: Mapping[str, str | int] = MappingProxyType({})
    repairs: bool = False
    integer: Flags | None = None
    noisy: bool = False
    compiles: bool | None = None
    joint: bool = False
    by_point: bool = False

    @property
    def dimension(self) -> int:
        """The number of search variables d."""
        return len(self.lower)

    @property
    def unscored(self) -> Problem:
        """The problem itself, where this one stands for it and returns the values that a study records."""
        return self

    @abstractmethod
    def evaluate(self, x: Floats) -> Floats:
        """Return the (n,) objective values of the (n, d) points ``x``, each finite or +inf; lower is better."""

    def noiseless(self, x: Floats) -> Floats:
        """Return the (n,) true values of the (n, d) points ``x`` of a noisy problem; of another, its values."""
        return self.evaluate(x)

    def violations(self, x: Floats) -> Floats | None:  # noqa: ARG002 - part of the contract
        """Return the (n, m) constraint violations of the (n, d) points ``x``, or None without constraints (default).

        A point is feasible where all are at most 0. They must depend on the point alone, bit by bit, whatever the
        batch: the best point is evaluated again alone, and must then be feasible again. What an optimizer sees of an
        infeasible point is up to the study (:mod:`bench.trial.scoring.constraints`); :meth:`evaluate` need not know.
        """
        return None

    def repair(self, x: Floats) -> Floats:
        """Return the (n, d) feasible points nearest to ``x`` by the problem's own rule; by default, clip to the box."""
        return np.clip(x, self.lower, self.upper)

    def describe(self, x: Floats) -> dict[str, float]:  # noqa: ARG002 - part of the contract
        """Return the domain metrics of the (d,) point ``x``, one column each in the tidy frame; by default none."""
        return {}

    def open(self) -> None:  # noqa: B027 - few problems need it
        """Get ready for an evaluation, such as start a program; the time that it takes counts in no evaluation's limit.

        By default nothing is done.
        """

    def close(self) -> None:  # noqa: B027 - few problems hold anything
        """Release what evaluations use, such as a program that runs; called at the end of every trial.

        The problem may be evaluated again afterwards. By default nothing is held.
        """


class FunctionProblem(Problem):
    """A user's own function as a problem.

    Example:
        >>> sphere = FunctionProblem(lambda x: (x**2).sum(), [-5] * 3, [5] * 3, name="sphere")

    Args:
        fun: maps one (d,) point to a number, or (n, d) points to (n,) or (n, 1) values.
        lower: (d,) lower bounds.
        upper: (d,) upper bounds, each above its lower bound.
        name: the name results are stored under.
        vectorized: whether ``fun`` takes many points at once; None: one more call finds out, before the first
            evaluation (in a study, once a job). It has two points, or three of two variables, so that no axis can be
            taken for the other. Where that gives a value for each, ``fun`` takes many; where it raises, or returns
            anything else, it takes one.
        optimum: the best known value, if any.
        optimum_point: (d,) where it is reached, if that is known.
        variables: d different names of the search variables; by default x1, x2, …
        features: what kind of problem it is, see :class:`Problem`.
        violations: maps (n, d) points to their (n, m) constraint violations, or one (d,) point to m of them with
            ``vectorized=False``; without, the problem has no constraints.
        integer: d flags, true for the variables that are whole numbers; without, there are none.
        noiseless: maps points to their true values as ``fun`` does; ``fun`` then takes a numpy.random.Generator, too,
            ``fun(x, rng)``, and returns what can be observed. Without, the problem has no noise.

    Raises:
        BenchError: when the bounds are not two finite vectors of one length with lower < upper, or names repeat.
    """

    def __init__(
        self,
        fun: Callable[..., ArrayLike],
        lower: ArrayLike,
        upper: ArrayLike,
        *,
        name: str = "function",
        vectorized: bool | None = None,
        optimum: float | None = None,
        optimum_point: ArrayLike | None = None,
        variables: Sequence[str] | None = None,
        features: Mapping[str, str | int] = MappingProxyType({}),
        violations: Callable[..., ArrayLike] | None = None,
        integer: ArrayLike | None = None,
        noiseless: Callable[..., ArrayLike] | None = None,
    ) -> None:
        self.name, self.lower, self.upper = name, *own_box(name, lower, upper)
        self.optimum = optimum
        self.optimum_point = None if optimum_point is None else np.array(optimum_point, dtype=np.float64)
        self.features = dict(features)
        self.variables = (
            tuple(variables) if variables is not None else tuple(f"x{i + 1}" for i in range(self.dimension))
        )
        if len(set(self.variables)) != self.dimension:
            raise BenchError(f"problem {name!r}: give {self.dimension} different variable names, not {self.variables}")
        self._fun: Callable[..., Any] = fun
        self._vectorized, self.by_point = vectorized, vectorized is False
        self.integer = None if integer is None else np.array(integer, dtype=bool)
        self.noisy = noiseless is not None
        self._violations = violations
        self._noiseless = noiseless

    def evaluate(self, x: Floats, rng: np.random.Generator | None = None) -> Floats:
        """Return the (n,) values of ``fun`` at the (n, d) points ``x``; a noisy one needs ``rng``."""
        return self._computed(self._fun, x, rng) if self.noisy else self._computed(self._fun, x)

    def noiseless(self, x: Floats) -> Floats:
        """Return the (n,) true values of the (n, d) points ``x``."""
        return self._computed(self._fun if self._noiseless is None else self._noiseless, x)

    def violations(self, x: Floats) -> Floats | None:
        """Return the (n, m) constraint violations of the (n, d) points ``x``, or None without constraints."""
        if self._violations is None:
            return None
        violate = self._violations
        violations = violate(x) if self._takes_many(x) else [np.ravel(violate(row)) for row in x]
        return np.asarray(violations, dtype=np.float64)

    def _computed(self, function: Callable[..., ArrayLike], x: Floats, *arguments: object) -> Floats:
        if not self._takes_many(x):
            return np.array([_number(function(row, *arguments)) for row in x], dtype=np.float64)
        values = np.asarray(_unmasked(function(x, *arguments)), dtype=np.float64)
        return values.reshape(len(x)) if values.shape == (len(x), 1) else values

    def find_out(self) -> None:
        """Find out by a call whether the function takes many points at once, unless that is known."""
        self._takes_many(self.lower[np.newaxis])

    def _takes_many(self, x: Floats) -> bool:
        """Return whether the function takes many points at once; try it in the box, and where it fails at ``x``."""
        if self._vectorized is None:
            function = self._fun if self._noiseless is None else self._noiseless
            n = 2 if self.dimension != 2 else 3
            inside = self.lower + (self.upper - self.lower) * np.linspace(0.4, 0.6, n)[:, np.newaxis]
            inside = inside if self.integer is None else np.where(self.integer, np.rint(inside), inside)
            try:
                self._vectorized = _takes(function, inside)
            except Exception:
                self._vectorized = _takes(function, np.resize(x, (n, self.dimension)))
            self.by_point = not self._vectorized
        return self._vectorized


def _takes(function: Callable[..., ArrayLike], points: Floats) -> bool:
    """Return whether a function takes these points at once; raises an exception where it takes one alone neither."""
    n = len(points)
    try:
        return np.asarray(function(points.copy()), dtype=np.float64).shape in ((n,), (n, 1))
    except StopRun:  # of one point, which a run will not have evaluated
        return False
    except Exception as many:  # it may raise anything
        try:
            _number(function(points[0].copy()))
        except Exception as one:
            if repr(one) == repr(many):
                raise
            raise ValueError(
                f"its function takes neither one point ({type(one).__name__}: {one}) nor {n} at once "
                f"({type(many).__name__}: {many})"
            ) from one
        return False


def _number(value: ArrayLike) -> float:
    """Return the value of one point, which may be in an array of its own; raises TypeError for no single number."""
    array = np.asarray(_unmasked(value))
    if array.size != 1 or array.dtype == object:
        raise TypeError(f"a function must return one number for a point, not {value!r:.100}")
    return float(array.item())


def _unmasked(values: ArrayLike) -> ArrayLike:
    """Return what is no masked array; raises TypeError for one, as numpy would take the numbers under the mask."""
    if isinstance(values, np.ma.MaskedArray):
        raise TypeError("a function must return plain numbers; fill the masked ones with inf or another value")
    return values


def own_box(name: str, lower: ArrayLike, upper: ArrayLike) -> tuple[Floats, Floats]:
    """Return copies of a problem's bounds, (d,) float64, that cannot be written to.

    Raises:
        BenchError: unless they are two vectors of one length, finite, with lower < upper.
    """
    try:
        low, high = (np.array(bounds, dtype=np.float64, ndmin=1) for bounds in (lower, upper))
    except (TypeError, ValueError) as error:
        raise BenchError(f"problem {name!r}: its bounds are no numbers: {error}") from error
    if low.ndim != 1 or low.shape != high.shape:
        raise BenchError(
            f"problem {name!r}: lower and upper must be vectors of one length; give one value for each variable"
        )
    if (wrong := ~(np.isfinite(low) & np.isfinite(high) & (low < high))).any():
        first = int(wrong.argmax())
        raise BenchError(
            f"problem {name!r}: every lower bound must be finite and below its upper bound, also finite; those of "
            f"variable {first + 1} are {float(low[first])!r} and {float(high[first])!r}"
        )
    low.flags.writeable = high.flags.writeable = False
    return low, high


def with_own_box(problem: Problem) -> Problem:
    """Replace a problem's bounds and integer flags by copies that cannot be written to; return the problem.

    Otherwise code that computes in place, such as ``low = self.lower; low -= 1``, would move the box of later trials.

    Raises:
        BenchError: where the problem lacks an attribute, or the bounds are not a box; see :func:`own_box`.
    """
    if missing := [name for name in ("name", "variables", "lower", "upper") if not hasattr(problem, name)]:
        raise BenchError(f"the problem {type(problem).__name__} has no {' and no '.join(missing)}; see bench.Problem")
    lower, upper = own_box(problem.name, problem.lower, problem.upper)
    integer = None if problem.integer is None else np.array(problem.integer)
    if integer is not None:
        integer.flags.writeable = False
    for name, array in (("lower", lower), ("upper", upper), ("integer", integer)):
        with suppress(AttributeError):  # a property computes it
            object.__setattr__(problem, name, array)  # also of a frozen dataclass
    return problem
