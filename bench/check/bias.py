"""Diagnose biases of an optimizer: places of the box that it favours, and trials that are not independent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from bench.analysis import holm
from bench.analysis.finished_trials import CLAMPED
from bench.check.conformance.subject import Subject
from bench.check.problems import SHIFT
from bench.check.runs import Runs, make_runs, on_bound
from bench.check.verdict import Verdict
from bench.contract.optimizer import Optimizer
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError

LIMIT = 10.0  # a geometric mean ratio of errors above this is a bias (Kudela 2022)
FLOOR = 1e-8  # errors below this count as equal
ALPHA = 0.01  # of the tests for structural bias
ALPHA_STARTS = 0.001  # of the tests of starts: an unbiased optimizer then passes all checks for 99% of the seeds
HALFWAY = 0.25  # mean distance of a uniform coordinate from the centre, as a share of the box's width

PUBLISHED = "in a published algorithm, report the bias and offer a corrected version under another name, never silently"


def diagnose(optimizer: Optimizer | Subject, **settings: object) -> list[Verdict]:
    """Return the verdicts on one optimizer; the settings are those of :func:`diagnose_all`.

    Example:
        >>> [verdict.check for verdict in diagnose(bench.load_optimizer("gwo")) if not verdict.passed]

    Raises:
        BenchError: when the optimizer fails on one of the functions, ends its process or prints without end.
    """
    (verdicts,) = diagnose_all([optimizer], **settings)
    if isinstance(verdicts, BenchError):
        raise verdicts
    return verdicts


def diagnose_all(optimizers: Sequence[Optimizer | Subject], **settings: Any) -> Iterator[list[Verdict] | BenchError]:
    """Yield verdicts on each optimizer's centre bias, structural bias, boundary clamping, and starts and seeds.

    They come as soon as they are known; a BenchError stands for those on an optimizer that failed. The settings are
    those of :func:`bench.check.runs.make_runs`.
    """
    for made in make_runs(optimizers, **settings):
        yield made if isinstance(made, BenchError) else [check(made) for check in CHECKS]


def centre_bias(runs: Runs) -> Verdict:
    """Judge centre bias: how much lower errors are when the optimum lies at the centre of the box.

    The deciding number is the geometric mean over five functions of the ratio of errors, moved to centred; errors
    count as at least 1e-8. An unbiased method has a ratio near 1, one that draws its points to the centre a large one
    (Kudela, Nature Machine Intelligence 4, 2022, doi:10.1038/s42256-022-00579-0).
    """
    centred, moved = (
        [mean_log_error([run.best for run in those]) for those in place.values()]
        for place in (runs.centred, runs.moved)
    )
    ratio = float(np.exp(np.mean(np.subtract(moved, centred))))
    passed = ratio <= LIMIT
    finding = (
        f"errors are {ratio:.2g} times as high when the optimum is moved from the centre of the box by "
        f"{SHIFT:.0%} of it ({'below' if passed else 'above'} the limit of {LIMIT:g})"
    )
    if ratio < 1 / LIMIT:
        finding += ": the method does better away from the centre"
    remedy = (
        f"look for moves that shrink coordinates or scale them about the origin or the middle of the box; {PUBLISHED}"
    )
    return _verdict("centre bias", passed, finding, remedy, ratio)


def mean_log_error(errors: ArrayLike) -> float:
    """Return the mean logarithm of the errors; one that is not finite counts as the largest float."""
    errors = np.nan_to_num(errors, nan=np.inf, posinf=np.finfo(float).max)
    return float(np.log(np.maximum(errors, FLOOR)).mean())


def structural_bias(runs: Runs) -> Verdict:
    """Judge structural bias: whether the best points on pure noise are uniform in the box, as for an unbiased method.

    In each of two boxes every coordinate is compared with the uniform law by a Kolmogorov-Smirnov test, and the runs'
    mean distances from the centre with that of uniform points by Wilcoxon's signed-rank test. The deciding number
    is the smallest p-value after Holm's adjustment over all of these tests. (Kononova et al., Information Sciences 298,
    2015, doi:10.1016/j.ins.2014.11.035; Vermetten et al., IEEE Transactions on Evolutionary Computation 26(6), 2022,
    doi:10.1109/TEVC.2022.3189848.)
    """
    finals = {box: np.array([run.x for run in those]) for box, those in runs.noise.items()}
    spreads = {box: np.abs(x - 0.5).mean(axis=1) for box, x in finals.items()}
    p = np.concatenate([[_p_of_spread(spreads[box]), *_p_of_uniform(x)] for box, x in finals.items()])
    smallest = float(holm(p).min())
    passed = smallest > ALPHA
    distances = " and ".join(f"{spread.mean():.2g} in {box}^d" for box, spread in spreads.items())
    finding = (
        f"on pure noise the best points of {sum(map(len, finals.values()))} runs in {len(finals)} boxes "
        f"{'look' if passed else 'are not'} uniform (smallest p = {smallest:.2g} of {len(p)} tests, Holm; level "
        f"{ALPHA:g}); their mean distance from the centre, 0.25 of the width for uniform points, is {distances}"
    )
    remedy = (
        "look for moves that are drawn to the centre, the origin or the bounds, such as means of leaders, products "
        f"with coordinates and clips; {PUBLISHED}"
    )
    return _verdict("structural bias", passed, finding, remedy, smallest)


def boundary_clamping(runs: Runs) -> Verdict:
    """Judge boundary clamping: how many coordinates of the best points lie exactly on a bound, where no optimum lies.

    The deciding number is the share of those coordinates, on the functions or on noise, whichever is larger.
    """
    groups = {
        "on functions with their optimum inside the box": [*runs.centred.values(), *runs.moved.values()],
        "on pure noise": runs.noise.values(),
    }
    shares, sentences = [], []
    for where, problems in groups.items():
        problem_runs = list(chain.from_iterable(problems))
        shares.append(float(on_bound(np.array([run.x for run in problem_runs])).mean()))
        evaluated = np.mean([run.clamped for run in problem_runs])
        sentences.append(f"{shares[-1]:.2%} of the best points' and {evaluated:.2%} of all coordinates {where}")
    passed = max(shares) <= CLAMPED
    finding = (
        f"{' and '.join(sentences)} lie exactly on a bound of the box "
        f"({'within' if passed else 'above'} the limit of {CLAMPED:.0%} for the best points)"
    )
    remedy = f"reflect or redraw coordinates that leave the box instead of clipping them to the bound; {PUBLISHED}"
    return _verdict("boundary clamping", passed, finding, remedy, max(shares))


def starts_and_seeds(runs: Runs) -> Verdict:
    """Judge starts and seeds: whether trials of different seeds are independent and start anywhere in the box.

    Two runs on one function with different seeds must differ, and so must the first generations of two runs on noise,
    unless every run begins at one and the same point. One point of each first generation is compared with the uniform
    law, coordinate by coordinate, and with that of the run with the next seed (Kolmogorov-Smirnov and Pearson's r). The
    deciding number is the smallest p-value after Holm's adjustment, None where there is nothing to test.
    """
    check, independent = "starts and seeds", "draw every random number from the rng that minimize is given"
    problems = [*runs.centred.values(), *runs.moved.values()]
    total = sum(map(len, problems))
    repeats = total - sum(len({run.course for run in those}) for those in problems)
    if repeats:
        finding = (
            f"{repeats} of {total} runs on functions repeat another run to the last point, although their seeds differ"
        )
        remedy = f"{independent}; make one trial of a deterministic method: all its trials are equal"
        return _verdict(check, False, finding, remedy)
    starts = [run.first for run in chain.from_iterable(runs.noise.values())]
    different = len({start.tobytes() for start in starts})
    if different == 1 and len(starts[0]) == 1:
        return _verdict(check, True, "every run starts at the same point and then depends on its seed")
    if different < len(starts):
        finding = f"{len(starts)} runs with different seeds have only {different} different first generations"
        return _verdict(check, False, finding, f"{independent}, and the start from objective.initial")
    points = np.array([start[i % len(start)] for i, start in enumerate(starts)])  # those of a run may be dependent
    uniform, adjacent = _p_of_uniform(points), _p_of_neighbours(points)
    adjusted = holm(np.concatenate([uniform, adjacent]))
    smallest, trouble = float(adjusted.min()), int(adjusted.argmin())
    passed = smallest > ALPHA_STARTS
    conclusion = (
        "look uniform in the box and independent"
        if passed
        else ("are not uniform in the box" if trouble < len(uniform) else "depend on the starts of adjacent seeds")
    )
    finding = (
        f"the starts of {len(starts)} seeds {conclusion} (smallest p = {smallest:.2g} of {len(adjusted)} tests, Holm; "
        f"level {ALPHA_STARTS:g})"
    )
    return _verdict(check, passed, finding, f"start from objective.initial; {PUBLISHED}", smallest)


CHECKS: tuple[Callable[[Runs], Verdict], ...] = (centre_bias, structural_bias, boundary_clamping, starts_and_seeds)


def _verdict(check: str, passed: bool, finding: str, remedy: str = "", figure: float | None = None) -> Verdict:
    return Verdict(check, "bias", passed, finding, "" if passed else remedy, figure)


def _p_of_uniform(x: Floats) -> list[float]:
    """Return the p-value of each coordinate of (n, d) points against the uniform law on [0, 1]."""
    return [float(stats.ks_1samp(values, stats.uniform.cdf).pvalue) for values in x.T]


def _p_of_spread(spread: Floats) -> float:
    """Return the p-value of the runs' mean distances from the centre, (n,), against that of uniform points."""
    return float(stats.wilcoxon(spread - HALFWAY).pvalue) if (spread != HALFWAY).any() else 1.0


def _p_of_neighbours(x: Floats) -> list[float]:
    """Return the p-value of each coordinate's correlation from one of the (n, d) points to the next."""
    return [float(stats.pearsonr(values[:-1], values[1:]).pvalue) if np.ptp(values) else 1.0 for values in x.T]
