"""The rules of a problem: values that depend on the point alone, a box, a repair, an optimum that holds."""

from __future__ import annotations

from collections.abc import Sequence
from time import monotonic

import numpy as np

from bench.check.conformance.problem_probes import SECONDS, improved
from bench.check.conformance.problem_subject import (
    ProblemSubject,
    feasible_values,
    observed,
    rounded,
    sample,
    true_values,
)
from bench.check.conformance.recording import ViolationError
from bench.check.conformance.single import single_run
from bench.contract.numbers import is_finite
from bench.contract.objective import as_values, integer_flags, repaired
from bench.contract.problem import Problem
from bench.contract.typing import Flags, Floats
from bench.helpers.errors import BenchError
from bench.helpers.text import count, listed
from bench.plugins import registry
from bench.plugins.loading import family, load_optimizer
from bench.plugins.selection import is_of_suite
from bench.trial.scoring import constraints, scored
from bench.trial.scoring.problem import violations_of

TOLERANCE = 1e-9
"""A value at most this far below an optimum, relatively to it and at least absolutely, counts as rounding."""

SAMPLED = 1_000  # points that no claimed optimum may be above
SEARCHES = ("cma-es", "minion:LSHADE")
SEARCH_BUDGET = 20_000  # evaluations of a search, for every variable

_PURE = (
    "compute a value from the point alone: no counter, cache or generator, and no statistic of the batch; where the "
    "difference is rounding, a matrix product is the cause, which sums one row otherwise than many: sum products of "
    "elements along an axis"
)


def check_declaration(subject: ProblemSubject) -> str:
    """Name, box, variables, flags of integers and features can be used by a study."""
    problem = subject.fresh()
    d = problem.dimension
    if not isinstance(problem.name, str) or not problem.name:
        raise ViolationError(f"its name is {problem.name!r}", "give it the name under which it is loaded, as a text")
    if isinstance(subject.source, str) and ":" not in subject.source and problem.name != subject.source:
        raise ViolationError(
            f"loaded as {subject.source!r}, it calls itself {problem.name!r}",
            "give it the name under which it is loaded",
        )
    names = tuple(problem.variables)
    if len(names) != d or len(set(names)) != d or not all(isinstance(name, str) for name in names):
        raise ViolationError(f"its {d} variables have the names {names}", f"give {d} different names, as texts")
    for key, value in problem.features.items():
        if not isinstance(key, str) or not isinstance(value, (str, int)):
            raise ViolationError(f"its feature {key!r} is {value!r}", "features are texts or whole numbers, by name")
    for what in ("optimum", "repaired_optimum"):
        if (value := getattr(problem, what)) is not None and not is_finite(value):
            raise ViolationError(f"its {what} is {value!r}", "give a finite number, or None where none is known")
    try:
        scored(problem, constraints.DEFAULT)
    except BenchError as error:
        raise ViolationError(str(error), "give each variable its bounds, and each constraint a column") from error
    return f"{d} variable{'s' * (d > 1)} in a box, with names"


def check_values(subject: ProblemSubject) -> str:
    """Values have the shape (n,), as float64, and are finite or +inf: at random points, in corners, on every side."""
    problem = subject.fresh()
    remedy = "return one float64 for each point: a finite number, or +inf where the point is worth nothing"
    x = np.vstack([sample(problem, 100, subject.seed), special(problem, subject.seed)])
    until = monotonic() + SECONDS
    for points in (x, x[:1], x[:0], sample(problem, SAMPLED, subject.seed + 1)):
        if monotonic() > until:  # a slow problem
            break
        returned = problem.noiseless(points.copy())
        try:
            values = as_values(problem, returned, len(points))
        except (TypeError, ValueError) as error:
            raise ViolationError(str(error), remedy) from error
        if (kind := np.asarray(returned).dtype) != np.float64:
            raise ViolationError(f"its values are {kind}, not float64", remedy)
        for name, wrong in (("NaN", np.isnan(values)), ("-inf", values == -np.inf)):
            if wrong.any():
                where = points[int(wrong.argmax())].tolist()
                raise ViolationError(
                    f"{int(wrong.sum())} of {len(points)} values are {name}, such as at {where}", remedy
                )
    values = true_values(problem, x)
    infinite = f", {int(np.isinf(values).sum())} of them +inf" if np.isinf(values).any() else ""
    return f"{len(x)} values, one a point{infinite}; also of one point and of none"


def special(problem: Problem, seed: int) -> Floats:
    """Return corners of the box, its centre, and points on a side, as the harness evaluates them."""
    rng, d = np.random.default_rng(seed), problem.dimension
    corners = np.where(rng.random((16, d)) < 0.5, problem.lower, problem.upper)
    sides = rng.uniform(problem.lower, problem.upper, (16, d))
    at = rng.integers(d, size=16), np.arange(16)
    sides[at[1], at[0]] = corners[at[1], at[0]]
    centre = (problem.lower + problem.upper)[None] / 2
    return rounded(np.vstack([problem.lower, problem.upper, centre, corners, sides]), integer_flags(problem))


def check_batches(subject: ProblemSubject) -> str:
    """A point has the same bits alone, in a batch, in another order, a second time and after other calls."""
    problem = subject.fresh()
    x = sample(problem, 64, subject.seed)
    for what, function in (("value", true_values), ("violation", violations_of)):
        whole = function(problem, x)
        _expect_same(what, whole, function(problem, x), "a second time")
        _expect_same(what, whole, np.concatenate([function(problem, row[None]) for row in x]), "alone")
        _expect_same(what, whole, function(problem, x[::-1])[::-1], "in another order")
        _expect_same(what, whole, np.concatenate([function(problem, part) for part in np.split(x, 4)]), "in parts")
        subject.run(instance=problem, seed=1)
        _expect_same(what, whole, function(problem, x), "after other calls")
    return f"{len(x)} points have the same bits alone, in batches, in another order and after other calls"


def _expect_same(what: str, first: Floats, second: Floats, when: str) -> None:
    different = (first != second) & ~(np.isnan(first) & np.isnan(second))
    if first.shape != second.shape or different.any():
        with np.errstate(invalid="ignore"):
            far = float(np.max(np.abs(first - second)[different] / np.maximum(np.abs(first[different]), 1e-300)))
        rounding = "by rounding alone, " if far < 1e-12 else ""
        raise ViolationError(
            f"{int(different.sum())} of {different.size} {what}s differ {when}, {rounding}by up to {far:.2g} of "
            f"the {what}",
            _PURE,
        )


def check_noise(subject: ProblemSubject) -> str:
    """Check that point and generator alone decide the values of a noisy problem."""
    problem = subject.fresh()
    if not problem.noisy:
        return "declares no noise"
    x = sample(problem, 64, subject.seed)
    if (observed(problem, x, 1) != observed(problem, x, 1)).any():
        raise ViolationError("the same generator gives other values", "draw the noise from rng alone")
    true, one, other = true_values(problem, x), observed(problem, x, 1), observed(problem, x, 2)
    if (one == other).all():
        how = "the true values" if (one == true).all() else "the same values for another generator"
        raise ViolationError(f"it declares noise and returns {how}", "draw the noise from rng, or set noisy = False")
    return f"noise moves {np.mean(one != true):.0%} of the values, and the generator decides it"


def check_box_repair(subject: ProblemSubject) -> str:
    """Repaired points lie in the box, stay where they are when repaired again, and are feasible where it says so."""
    problem, rng = subject.fresh(), np.random.default_rng(subject.seed)
    width, flags = problem.upper - problem.lower, integer_flags(problem)
    x = rng.uniform(problem.lower - width, problem.upper + width, (200, problem.dimension))
    try:
        points = repaired(problem, x)
        again = repaired(problem, points)
    except (TypeError, ValueError) as error:
        raise ViolationError(str(error), "return an array of the shape that repair is given") from error
    remedy = "clip to the box as the last step, and leave a point that needs no repair as it is"
    outside = ~((points >= problem.lower) & (points <= problem.upper)).all(axis=1)
    if outside.any():
        finding = f"{int(outside.sum())} of {len(x)} repaired points lie outside the box, such as"
        raise ViolationError(f"{finding} {points[outside][0].tolist()}", remedy)
    moved = np.abs(again - points) > TOLERANCE * width
    if moved.any():
        raise ViolationError(f"{int(moved.any(axis=1).sum())} of {len(x)} points move when repaired again", remedy)
    excess = violations_of(problem, rounded(points, flags))
    feasible = (excess <= 0).all(axis=1)
    if problem.repairs and not feasible.all():
        raise ViolationError(
            f"{int((~feasible).sum())} of {len(x)} repaired points violate a constraint, by up to {excess.max():.2g}, "
            "although it declares repairs = True",
            "let repair end at points whose violations are at most 0, or set repairs = False",
        )
    share = f", {np.mean(feasible):.0%} feasible" if excess.size else ""
    return f"{len(x)} points from in and around the box: repaired ones lie inside and stay{share}"


def check_optimum(subject: ProblemSubject) -> str:
    """No random point is below the claimed optimum, which is reached at the claimed point, where one is claimed."""
    problem = subject.fresh()
    if problem.optimum is None:
        return "claims no optimum"
    x = np.vstack([sample(problem, SAMPLED, subject.seed), special(problem, subject.seed)])
    values = feasible_values(problem, x)
    lowest = float(values.min())
    if lowest < _least(problem.optimum):
        raise ViolationError(f"a random point has {lowest!r}, below the optimum of {problem.optimum!r}", _OPTIMUM)
    if problem.optimum_point is None:
        _expect_lowest(problem, x[values.argmin()], "the best random point", subject.seed)
        return f"none of {len(x)} points is below {problem.optimum:.10g}; where that is reached is not claimed"
    best = np.asarray(problem.optimum_point, dtype=np.float64)
    if best.shape != problem.lower.shape or not ((best >= problem.lower) & (best <= problem.upper)).all():
        raise ViolationError(f"its optimum_point {best.tolist()} is no point of the box", _OPTIMUM)
    value = float(feasible_values(problem, best[None])[0])
    if not abs(value - problem.optimum) <= problem.optimum - _least(problem.optimum):
        raise ViolationError(f"its optimum_point has {value!r}, not the optimum of {problem.optimum!r}", _OPTIMUM)
    for start, what in ((best, "its optimum_point"), (x[values.argmin()], "the best random point")):
        _expect_lowest(problem, start, what, subject.seed)
    return f"{problem.optimum:.10g} is reached at the claimed point, and none of {len(x)} points is below"


_OPTIMUM = "give the lowest feasible value that is known, and in optimum_point where it is, or None"


def _expect_lowest(problem: Problem, start: Floats, what: str, seed: int) -> None:
    """Raise ViolationError where a short search from a point gets below the claimed optimum."""
    found, value = improved(problem, start, seed)
    if problem.optimum is not None and value < _least(problem.optimum):
        raise ViolationError(
            f"a search from {what} finds {value!r} at {found.tolist()}, below the optimum of {problem.optimum!r}",
            _OPTIMUM,
        )


def _least(optimum: float) -> float:
    """Return the lowest value that is no news beside a claimed optimum."""
    return optimum - TOLERANCE * max(1.0, abs(optimum))


def check_instances(subject: ProblemSubject) -> str:
    """The other instances of a suite's function have other values at the same points."""
    if not isinstance(subject.source, str) or not is_of_suite(subject.source):
        return "no suite's instance"
    grid = registry.grid(family(subject.source))
    if grid is None or not grid.instances:
        return "a suite without instances"
    problem, member = subject.fresh(), grid.member(subject.source)
    shares = np.random.default_rng(subject.seed).random((64, problem.dimension))
    values = _at(problem, shares)
    others = [name for name in grid.names([member.function], [member.dimension]) if name != subject.source]
    alike = [name for name in others if _alike(values, _at(type(subject)(name, subject.options).fresh(), shares))]
    if alike:
        raise ViolationError(
            f"it has the values of {listed(alike)} at all of {len(shares)} points", "let the instance decide the values"
        )
    return f"its values differ from those of {count(len(others), 'other instance')}"


def _alike(values: Floats, others: Floats) -> bool:
    return bool(np.isfinite(values).any()) and np.array_equal(values, others)


def _at(problem: Problem, shares: Floats) -> Floats:
    """Return the (n,) true values at shares of the problem's own box."""
    flags: Flags = integer_flags(problem)
    return true_values(problem, rounded(problem.lower + shares * (problem.upper - problem.lower), flags))


def check_search(
    subject: ProblemSubject, searches: Sequence[str] = SEARCHES, search_budget: int = SEARCH_BUDGET
) -> str:
    """No search gets below the claimed optimum."""
    problem = subject.fresh()
    if problem.optimum is None:
        return "claims no optimum"
    budget, closest, missing = search_budget * problem.dimension, {}, []
    for name in searches:
        try:
            optimizer = load_optimizer(name)
        except BenchError as error:
            missing.append(f"; not searched by {name}: {error}")
            continue
        handled = scored(problem, constraints.DEFAULT)
        found = single_run(handled, optimizer, budget, subject.seed, name)
        value = float(feasible_values(problem, found.x[None])[0])
        if value < _least(problem.optimum):
            raise ViolationError(
                f"{name} finds {value!r} at {found.x.tolist()}, below the optimum of {problem.optimum!r}", _OPTIMUM
            )
        closest[name] = value - problem.optimum
    ends = ", ".join(f"{name} ends {gap:.3g} above" for name, gap in closest.items())
    return f"no search of {budget:,} evaluations gets below: {ends}{''.join(missing)}"
