"""Compare implementations of a suite's functions at common points: equal, equal up to a transformation, or different.

Every function is computed in a process of its implementation's own, so that a library that crashes, hangs or changes
global states costs its own row. Comparing needs no processes: :func:`compare` takes what each implementation returned.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from bench.check.conformance.problem_subject import rounded, true_values
from bench.errors import BenchError
from bench.execution.safe_runs import Begin, found, safe_runs
from bench.families import Grid, Member
from bench.objective import integer_flags
from bench.plugins import from_file, registry
from bench.plugins.loading import load_problem
from bench.sandbox.messages import describe_error
from bench.typing import Floats

POINTS = 64
"""Points at which a function is compared: one half anywhere in the box, the other about the optimum where it is known,
and the optimum itself."""

NEAR = 0.02  # of the box, how far the points about an optimum lie from it
INSTANCES = 3  # of a suite that has them
DIMENSION = 10  # where a function has it; else its smallest
ROUNDING = 1e-9  # relative to the larger of two values
SMALL = 1e-6  # of the largest value
TIMEOUT = 120.0  # seconds of one function

VERDICTS = ("bits", "rounding", "transformed", "different", "missing")


@dataclass(frozen=True)
class Sample:
    """The values that one implementation returned for a function.

    Attributes:
        box: (2, d) its bounds.
        optimum: its claimed optimum, NaN without.
        best: (d,) where it claims it, NaN without.
        raw: the values at the common points.
        shares: the values at the points that have the same shares of its own box.
        about: the values at the same offsets from its own optimum, NaN without.
    """

    box: Floats
    optimum: float
    best: Floats
    raw: Floats
    shares: Floats
    about: Floats


Samples = dict[Member, Sample | str]
"""The samples of an implementation's functions; a sentence where one is missing."""


@dataclass(frozen=True)
class FunctionVerdict:
    """The verdict on one function of another implementation.

    Attributes:
        other: the other implementation.
        member: function, dimension and instance.
        verdict: one of ``VERDICTS``: equal to the last bit, to rounding, up to a transformation; or not, or not there.
        detail: which transformation, how far apart, or why it is missing.
        agree: the share of the points at which the values agree to rounding.
        letter: of the function's version: implementations whose values agree have one letter, the suite itself has A.
    """

    other: str
    member: Member
    verdict: str
    detail: str = ""
    agree: float = 0.0
    letter: str = ""


def compare_suites(
    suite: str,
    others: Sequence[str],
    *,
    dimensions: Sequence[int] = (),
    options: Mapping[str, Any] | None = None,
    jobs: int = -1,
    seed: int = 0,
) -> list[FunctionVerdict]:
    """Compare the functions of a suite with those of others, at the same points.

    Args:
        suite: a family of problems with a grid, such as ``"cec2022"``.
        others: families with a grid, or functions in a file, ``"adapters.py:opfunu"``, which take the keywords
            ``function`` (its number, or its name where it has none), ``dimension`` and ``instance`` and return a
            problem.
        dimensions: to compare in; by default 10 where a function has it, else its smallest.
        options: of the suite's problems, such as ``{"rotate": False}``.
        jobs: functions computed at a time, -1 for one a core.
        seed: of the points.

    Returns:
        A comparison of every function with each other implementation, in order.

    Raises:
        BenchError: for an unknown suite, a dimension that it does not have, and a file that cannot be read.
    """
    grid = _grid(suite)
    for other in others:
        if not from_file.split(other):
            _grid(other)
    members = _members(grid, dimensions)
    with safe_runs(jobs, _ready) as begin:
        first = _samples(begin, suite, dict.fromkeys(members), seed, options or {})
        frames = {
            member: own if isinstance(own, str) else [own.box.tolist(), own.best.tolist()]
            for member, own in first.items()
        }
        samples = {other: _samples(begin, other, frames, seed, {}) for other in others}
    return [comparison for other in others for comparison in _judged(other, first, samples)]


def _ready() -> None:
    """Load this module once for all forks."""


def _grid(suite: str) -> Grid:
    grid = registry.grid(suite) if suite in registry.entries("problems") else None
    if grid is None:
        raise BenchError(
            f"{suite!r} is no suite; give a family of problems with functions and dimensions, such as cec2022, and to "
            "compare it with, another one or a function in a file, such as adapters.py:opfunu"
        )
    return grid


def _members(grid: Grid, dimensions: Sequence[int]) -> list[Member]:
    for dimension in dimensions:
        if dimension not in grid.dimensions:
            has = ", ".join(map(str, grid.dimensions))
            raise BenchError(f"{grid.suite} has no dimension {dimension}; it has {has}")
    members = []
    for function, sizes in grid.functions.items():
        chosen = [size for size in sizes if size in (dimensions or [DIMENSION])]
        if not (chosen or dimensions):
            chosen = [min(sizes)]
        numbers = range(1, min(grid.instances, INSTANCES) + 1) if grid.instances else (0,)
        members += [Member(function, size, number) for size in chosen for number in numbers]
    return members


def _samples(begin: Begin, source: str, frames: Mapping[Member, Any], seed: int, options: Mapping[str, Any]) -> Samples:
    """Compute functions side by side; return the sample of each, or why it is missing, as its frame may say already."""
    begun = {
        member: frame
        if isinstance(frame, str)
        else begin(source, sampled, source, member, frame, seed, dict(options), seconds=TIMEOUT)
        for member, frame in frames.items()
    }
    made: Samples = {}
    for member, call in begun.items():
        try:
            made[member] = call if isinstance(call, str) else found(call, lambda read: Sample(**read), "the function")
        except BenchError as error:
            made[member] = " ".join(str(error).split())
    return made


def sampled(
    source: str, member: Sequence[Any], frame: list[Any] | None, seed: int, options: dict[str, Any]
) -> Mapping[str, Any]:
    """Compute a function at the common points; return the fields of a :class:`Sample`.

    Args:
        source: the implementation.
        member: function, dimension and instance.
        frame: the first implementation's box and best point, from which the points are drawn; None for its own.
        seed: of the points.
        options: of the problem of a family.

    Raises:
        BenchError: where it has no such function, or fails.
    """
    function, dimension, instance = member
    try:
        if from_file.split(source):
            number = int(function[1:]) if re.fullmatch(r"f\d+", function) else function
            problem = load_problem(source, function=number, dimension=dimension, instance=max(1, instance))
        else:
            problem = load_problem(
                f"{source}-{function}-d{dimension}" + (f"-i{instance}" if instance else ""), **options
            )
        if problem.dimension != dimension:
            raise BenchError(f"it has {problem.dimension} variables in place of {dimension}")
        box, nowhere = np.array([problem.lower, problem.upper]), np.full(dimension, np.nan)
        best = nowhere if problem.optimum_point is None else np.asarray(problem.optimum_point, dtype=np.float64)
        base, origin = (box, best) if frame is None else map(np.array, frame)
        points, offsets = _points(base, origin, seed)
        flags = integer_flags(problem)
        at = {
            "raw": points,
            "shares": box[0] + (points - base[0]) / (base[1] - base[0]) * (box[1] - box[0]),
            "about": best + offsets,
        }
        values = {
            name: true_values(problem, rounded(x, flags)) if np.isfinite(x).all() else np.full(len(x), np.nan)
            for name, x in at.items()
        }
    except BenchError:
        raise
    except (Exception, SystemExit) as error:  # strangers' code may raise anything
        raise BenchError(describe_error(error)) from error
    return {
        "box": box,
        "optimum": np.nan if problem.optimum is None else float(problem.optimum),
        "best": best,
        **values,
    }


def _points(box: Floats, best: Floats, seed: int) -> tuple[Floats, Floats]:
    """Return the (n, d) common points, and offsets (n, d) from an optimum."""
    rng, width = np.random.default_rng(seed), box[1] - box[0]
    points = box[0] + rng.random((POINTS, box.shape[1])) * width
    offsets = (rng.random(points.shape) - 0.5) * 2 * NEAR * width
    if np.isfinite(best).all():
        half = POINTS // 2
        points[half:] = np.clip(best + offsets[half:], *box)
        points[-1], offsets[-1] = best, 0.0
    return points, offsets


def _judged(other: str, first: Samples, samples: Mapping[str, Samples]) -> Iterator[FunctionVerdict]:
    """Yield the comparisons with one other implementation, with the letters of versions over all of them."""
    for member, own in first.items():
        sample = samples[other][member]
        if isinstance(own, str) or isinstance(sample, str):
            yield FunctionVerdict(other, member, "missing", str(sample))
            continue
        verdict, detail = compare(own, sample)
        if verdict == "different" and (number := _renumbered(own, member, samples[other])):
            verdict, detail = "transformed", f"it has the values of its {number}"
        agree = float(np.mean(_close(own.raw, sample.raw)))
        letters = _letters([own, *(each[member] for each in samples.values())])
        yield FunctionVerdict(other, member, verdict, detail, agree, letters[1 + list(samples).index(other)])


def _renumbered(own: Sample, member: Member, theirs: Samples) -> str:
    """Return another function of the other implementation that has the values of this one; "" without any.

    Functions of one box are computed at the same points in the first half.
    """
    half = slice(POINTS // 2)
    for candidate, sample in theirs.items():
        if candidate == member or candidate[1:] != member[1:] or isinstance(sample, str):
            continue
        if np.array_equal(own.box, sample.box) and _close(own.raw[half], sample.raw[half]).all():
            return candidate.function
    return ""


def _letters(samples: Sequence[Sample | str]) -> list[str]:
    """Return a letter for each version among the samples of a function, "" for those that are missing."""
    versions: list[Sample] = []
    letters = []
    for sample in samples:
        if isinstance(sample, str):
            letters.append("")
            continue
        number = next((n for n, each in enumerate(versions) if _close(each.raw, sample.raw).all()), len(versions))
        versions += [sample] if number == len(versions) else []
        letters.append(chr(ord("A") + number))
    return letters


def compare(first: Sample, second: Sample) -> tuple[str, str]:
    """Return the verdict on two samples of a function, and the details."""
    views = {"": (first.raw, second.raw)}
    if not np.array_equal(first.box, second.box):
        views["at the same shares of another box"] = first.shares, second.shares
    if not np.array_equal(first.best, second.best):
        views["about its own optimum, which lies elsewhere"] = first.about, second.about
    usable = {where: pair for where, pair in views.items() if np.isfinite(pair[0]).any() and len(set(pair[1])) > 1}
    if np.array_equal(first.raw, second.raw, equal_nan=True):
        return "bits", ""
    if _close(first.raw, second.raw).all():
        return "rounding", f"relative differences of up to {_apart(first.raw, second.raw).max():.1e}"
    for where, (a, b) in usable.items():
        if where and _close(a, b).all():
            return "transformed", f"equal {where}"
    for where, (a, b) in usable.items():
        if scaled := _scaled(a, b):
            return "transformed", f"{scaled} {where}".rstrip()
    for where, (a, b) in usable.items():
        order = np.argsort(a, kind="stable")
        if np.isfinite(a).all() and all(b[i] < b[j] for i, j in pairwise(order) if a[i] < a[j]):
            return "transformed", f"its values have the same order {where}".rstrip()
    return "different", _difference(first, second)


def _apart(a: Floats, b: Floats) -> Floats:
    """Return the relative differences of values; values that are not finite are 0 apart where they are the same.

    Values below ``SMALL`` of the largest count as that large, as terms that cancel leave their rounding behind.
    """
    scale = SMALL * float(np.max(np.abs(a[np.isfinite(a)]), initial=0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(a - b) / np.maximum(np.maximum(np.abs(a), np.abs(b)), max(scale, 1e-300))
    return np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.nan_to_num(apart, nan=np.inf))


def _close(a: Floats, b: Floats) -> Any:
    return _apart(a, b) <= ROUNDING


def _scaled(a: Floats, b: Floats) -> str:
    """Return how values ``b`` are a scale and a shift of ``a``, in words; "" where they are not."""
    finite = np.isfinite(a) & np.isfinite(b)
    if finite.sum() < 3 or (np.isfinite(a) != np.isfinite(b)).any() or np.ptp(a[finite]) == 0:
        return ""
    x, y = a[finite], b[finite]
    low, high = x.argmin(), x.argmax()
    scale = (y[high] - y[low]) / (x[high] - x[low])
    shift = y[low] - scale * x[low]
    if scale == 0 or not (np.abs(scale * x + shift - y) <= ROUNDING * np.abs(y).max()).all():
        return ""
    moved = "" if abs(shift) <= ROUNDING * np.abs(y).max() else f"{shift:+.10g}"
    if abs(scale - 1) <= ROUNDING:
        return f"its value is the suite's {moved}"
    return f"its value is {scale:.10g} times the suite's {moved}".rstrip()


def _difference(first: Sample, second: Sample) -> str:
    """Return in words how far two samples are apart, and where."""
    apart = _apart(first.raw, second.raw)
    finite = np.isfinite(first.raw) & np.isfinite(second.raw)
    differing = apart[apart > ROUNDING]
    parts = [f"{len(differing)} of {len(apart)} values differ"]
    if np.isfinite(median := np.median(differing)):
        parts[0] += f", by {median:.2g} of the value in the median"
    if len(differing) > 2 and finite.sum() > 2 and np.ptp(second.raw[finite]) > 0:
        parts.append(f"rank correlation {spearmanr(first.raw[finite], second.raw[finite]).statistic:.3f}")
    if np.isfinite(first.best).all() and apart[-1] > ROUNDING:
        parts.append(f"{second.raw[-1]:.10g} in place of {first.raw[-1]:.10g} at the suite's optimum")
    if np.isfinite([first.optimum, second.optimum]).all() and first.optimum != second.optimum:
        parts.append(f"claims the optimum {second.optimum:.10g}, not {first.optimum:.10g}")
    if not np.array_equal(first.box, second.box):
        parts.append("another box")
    return "; ".join(parts)


def by_function(comparisons: Sequence[FunctionVerdict]) -> list[FunctionVerdict]:
    """Return one comparison for each function of each other implementation: the worst over dimensions and instances."""
    worst: dict[tuple[str, str], FunctionVerdict] = {}
    for each in comparisons:
        key = each.other, each.member.function
        before = worst.get(key, each)
        worse = max(before, each, key=lambda one: VERDICTS.index(one.verdict))
        worst[key] = replace(worse, agree=min(before.agree, each.agree), letter=max(before.letter, each.letter))
    return list(worst.values())
