"""How often a page claims a difference where there is none, in designs chosen to mislead it; its power; its intervals.

    python validation/claims.py [STUDIES]        # default: 2,000 a row; about a quarter of an hour

The functions are those of the page. *Any claim* is a winner, a difference over all problems or one on a problem, at the
levels that the design gets; all optimizers are equal, or the best two of them are, in the sense of A12. *These
problems* is the share of claims that the mean of A12 is not 0.5 where A12 differs between problems and is 0.5 in the
mean, and the share of 95% intervals that hold it; shown is the worst of several numbers of problems and trials. In
brackets: standard errors.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm, wilcoxon

from bench import analysis
from bench.analysis.across import p_of_means
from bench.analysis.direction import Effects, effects, intervals, mean_of, p_values, stacked, stratified
from bench.analysis.error_rates import Stratum, claims, levels
from bench.analysis.pairwise import holm
from bench.typing import Flags, Floats

Draw = Callable[[np.random.Generator, int, int, int], Floats]  # optimizers, studies, trials


def equal(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    return rng.standard_normal((optimizers, studies, trials))


def two_best(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    return equal(rng, optimizers, studies, trials) + 1.5 * (np.arange(optimizers) > 1)[:, np.newaxis, np.newaxis]


def spread(ratio: float) -> Draw:
    """Standard deviations from 1 to ``ratio``, so that A12 is 0.5 for every pair."""
    return lambda rng, k, studies, trials: (
        rng.standard_normal((k, studies, trials)) * np.geomspace(1, ratio, k)[:, np.newaxis, np.newaxis]
    )


def successes(rate: float) -> Draw:
    return lambda rng, k, studies, trials: (rng.random((k, studies, trials)) >= rate).astype(np.float64)


def mostly_tied(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    values = np.exp(equal(rng, optimizers, studies, trials))
    return values * (rng.random(values.shape) < 0.1)


def failures(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    values = equal(rng, optimizers, studies, trials)
    values[rng.random(values.shape) < 0.2] = np.inf
    return values


def skewed(rng: np.random.Generator, optimizers: int, studies: int, trials: int) -> Floats:
    """A lognormal first optimizer against normal ones, with a mean that leaves A12 at 0.5."""
    values = equal(rng, optimizers, studies, trials)
    quantiles = np.exp(1.5 * norm.ppf((np.arange(4_000) + 0.5) / 4_000))
    mean = brentq(lambda at: float(norm.cdf(at - quantiles).mean()) - 0.5, -9.0, 9.0)
    values[0] = np.exp(1.5 * values[0]) - mean
    return values


EQUALS = (  # name, draw, then designs of optimizers, problems and trials
    ("identical", equal, (
        (2, 1, 5), (2, 1, 15), (2, 2, 3), (2, 5, 5), (2, 7, 15), (2, 10, 30), (2, 18, 30), (2, 24, 1), (2, 24, 5),
        (2, 24, 15), (2, 29, 51), (2, 50, 5), (3, 1, 15), (3, 10, 15), (3, 24, 15), (5, 1, 15), (5, 1, 51), (5, 2, 15),
        (5, 5, 3), (5, 7, 5), (5, 18, 30), (5, 24, 1), (5, 24, 15), (5, 29, 15), (10, 1, 30), (10, 2, 15), (10, 10, 5),
        (10, 24, 15), (10, 50, 3),
    )),
    ("two tied best", two_best, (
        (3, 1, 15), (3, 1, 51), (3, 5, 15), (3, 10, 5), (3, 24, 15), (5, 1, 30), (5, 7, 15), (5, 24, 15), (5, 50, 3),
        (10, 1, 51), (10, 18, 15),
    )),
    ("spreads 1 to 3", spread(3.0), ((2, 1, 15), (2, 5, 5), (2, 24, 15), (5, 24, 5))),
    ("spreads 1 to 100", spread(100.0), (
        (2, 1, 5), (2, 1, 15), (2, 1, 51), (2, 2, 5), (2, 5, 3), (2, 24, 3), (2, 24, 15), (5, 1, 15), (5, 24, 5),
        (10, 7, 15),
    )),
    ("success .5", successes(0.5), ((2, 1, 15), (2, 24, 5), (5, 24, 15))),
    ("success .9", successes(0.9), ((2, 1, 30), (2, 1, 51), (2, 24, 15), (5, 1, 51), (5, 24, 5), (5, 24, 51))),
    ("90% ties", mostly_tied, ((2, 1, 51), (2, 24, 5), (2, 24, 15), (5, 10, 30))),
    ("20% failures", failures, ((2, 1, 15), (2, 24, 5), (5, 24, 15))),
)  # fmt: skip
SUBJECTS = (  # name, draw, optimizers, problems, trials, more
    *(("identical", equal, *design, {}) for design in (
        (2, 1, 15), (3, 1, 15), (5, 1, 15), (5, 2, 15), (5, 5, 3), (5, 8, 5), (5, 24, 5), (5, 24, 15), (10, 24, 15),
    )),
    *(("two tied best, others worse", two_best, *design, {}) for design in ((3, 1, 15), (5, 8, 15), (5, 24, 15))),
    *(("spreads 1 to 100", spread(100.0), *design, {}) for design in ((2, 1, 15), (5, 1, 15), (5, 8, 5), (5, 24, 15))),
    ("90% ties", mostly_tied, 5, 8, 30, {}), ("success .9", successes(0.9), 5, 24, 15, {}),
    ("20% failures", failures, 5, 24, 15, {}),
    ("sizes 51, 15, 15", equal, 3, 8, 15, {"sizes": (51, 15, 15)}),
    ("sizes 5, 51, 51", equal, 3, 8, 5, {"sizes": (5, 51, 51)}),
    *(("chosen for its results, naively", equal, *design, {"chosen": "naive"})
      for design in ((5, 8, 15), (10, 24, 15))),
    *(("chosen for its results, all pairs", equal, *design, {"chosen": "counted"})
      for design in ((5, 8, 15), (10, 24, 15))),
)  # fmt: skip
BBOB = (5, 4, 5, 5, 5)  # functions of its classes
CLASSES = (  # name, draw, optimizers, sizes of the classes of functions, trials
    *(("identical", equal, 5, sizes, trials)
      for sizes in (BBOB, (2, 22), (2, 2, 2, 18), (12, 12)) for trials in (5, 15)),
    *(("identical", equal, 2, sizes, 15) for sizes in (BBOB, (2, 22), (12, 12))),
    *((name, draw, 5, sizes, 15) for name, draw in (
        ("90% ties", mostly_tied), ("success .9", successes(0.9)), ("20% failures", failures),
        ("spreads 1 to 100", spread(100.0)), ("a skewed subject", skewed),
    ) for sizes in (BBOB, (2, 22))),
)  # fmt: skip
POPULATIONS = (  # shares and values of A12 of a problem, of mean 0.5
    ((0.8, 0.2), (0.6, 0.1)), ((0.9, 0.1), (0.55, 0.05)), ((0.95, 0.05), (0.525, 0.025)), ((0.2, 0.8), (0.9, 0.4)),
    ((0.1, 0.9), (0.95, 0.45)), ((0.05, 0.95), (0.975, 0.475)), ((0.5, 0.5), (1.0, 0.0)), ((0.5, 0.5), (0.8, 0.2)),
    ((0.6, 0.2, 0.2), (0.5, 0.9, 0.1)), ((0.7, 0.2, 0.1), (0.6, 0.35, 0.1)),
)  # fmt: skip
DESIGNS = ((5, 3), (10, 5), (10, 15), (20, 51))  # problems and trials
POWER = (  # optimizers, problems, trials, mean and SD over problems of the shift of the others
    (2, 24, 15, 0.2, 0.0), (2, 24, 15, 0.23, 0.25), (2, 24, 15, 0.2, 0.5), (2, 24, 15, 0.2, 1.0),
    (2, 10, 15, 0.3, 0.5), (5, 24, 15, 0.3, 0.5), (5, 18, 30, 0.3, 1.0), (2, 24, 15, 1.0, 0.5),
)  # fmt: skip


def main(studies: int) -> None:
    header("any claim", "k", "N", "n", "problem", "over all", "winner", "any")
    for name, draw, designs in EQUALS:
        for k, problems, trials in designs:
            row(name, k, problems, trials, *map(share, false_claims(draw, k, problems, trials, studies)))
    for name, sizes in (("sizes 5, 30", (5, 30)), ("sizes 3, 51", (3, 51)), ("sizes 15, 30, 51", (15, 30, 51))):
        for problems in (1, 24):
            found = false_claims(equal, len(sizes), problems, min(sizes), studies, sizes=sizes)
            row(name, len(sizes), problems, min(sizes), *map(share, found))
    for k, problems, trials in ((2, 1, 3), (2, 24, 5), (5, 24, 3)):
        shared = false_claims(equal, k, problems, trials, studies, instances=5)
        row("5 instances, any variance between", k, problems, trials, *map(share, shared))
    header("a subject against k - 1 rivals", "k", "N", "n", "problem", "over all", "parts", "any")
    for name, draw, k, problems, trials, more in SUBJECTS:
        row(name, k, problems, trials, *map(share, of_subject(draw, k, problems, trials, studies, **more)))
    header("a subject by class of functions", "k", "sizes", "n", "problem", "over all", "classes", "any")
    for name, draw, k, sizes, trials in CLASSES:
        row(name, k, "+".join(map(str, sizes)), trials, *map(share, by_class(draw, k, sizes, trials, studies)))
    header("better in all classes but the first", "k", "sizes", "problem", "class", "any")
    for k, sizes in ((5, BBOB), (5, (2, 22)), (5, (22, 2)), (2, BBOB), (2, (2, 22))):
        for shift in (0.5, 2.0):
            found = but_the_first(k, sizes, 15, shift, studies)
            row(f"by {shift} SD, 15 trials", k, "+".join(map(str, sizes)), *map(share, found))
    header("these problems, N 5 to 20, n 3 to 51", "claimed", "interval")
    for shares, values in POPULATIONS:
        held = [these(values, shares, problems, trials, studies) for problems, trials in DESIGNS]
        row(f"{values} on {shares}", *worst(held, (max, min)))
    header("interval, one problem, spread 10", "n", "A12 = .5", "A12 = .7", "A12 = .9")
    for trials in (3, 5, 10, 15, 30, 51):
        row("normal", trials, *(share(one_problem(true, trials, studies)) for true in (0.5, 0.7, 0.9)))
    header("found", "k", "N", "n", "these", "signed ranks")
    for k, problems, trials, shift, spread_of in POWER:
        row(f"shift {shift} SD, between problems {spread_of}", k, problems, trials,
            *map(share, power(k, problems, trials, shift, spread_of, studies)))  # fmt: skip
    first, second = np.zeros((studies, 51)), successes(0.85)(np.random.default_rng(1), 1, studies, 51)[0]
    row("success 1 against 0.85", 2, 1, 51, share(p_values(effects(first, second)) <= analysis.ALPHA), "")
    header("found with 5 instances of 5 trials", "between", "by instance", "across them")
    for variance in (0.2, 0.5, 0.8):
        row("one problem", variance, *map(share, by_instance(variance, studies)))


def worst(every: Sequence[Sequence[Flags]], which: Sequence[Callable[..., Flags]]) -> list[str]:
    """Return for each kind of flags the share of the design where it is largest, or smallest."""
    return [share(take(flags, key=np.mean)) for flags, take in zip(zip(*every, strict=True), which, strict=True)]


def header(*names: str) -> None:
    print("\n" + names[0].ljust(40) + "".join(name.rjust(15) for name in names[1:]), flush=True)


def row(name: str, *cells: object) -> None:
    print(name.ljust(40) + "".join(str(cell).rjust(15) for cell in cells), flush=True)


def share(flags: Flags) -> str:
    mean = float(flags.mean())
    return f"{mean:.3f} ({(mean * (1 - mean) / flags.size) ** 0.5:.3f})"


def false_claims(
    draw: Draw, k: int, problems: int, trials: int, studies: int,
    sizes: Sequence[int] = (), instances: int = 1,
) -> tuple[Flags, Flags, Flags, Flags]:  # fmt: skip
    """Return which studies claim anything false; with two tied best, any claim between these two, or a winner."""
    rng, pairs = np.random.default_rng((k, problems, trials)), k * (k - 1) // 2
    smaller = sorted(sizes)[-2] if sizes else trials * instances
    level = levels([smaller] * problems, pairs, pairs * problems)

    def strata() -> list[Stratum]:
        drawn: list[Stratum] = []
        for _ in range(instances):
            values = draw(rng, k, studies, max(sizes, default=trials))
            drawn.append([own[:, :size] for own, size in zip(values, sizes or [trials] * k, strict=True)])
        return drawn

    tied = 2 if draw is two_best else k
    on_problem, over_all, winner = claims((strata() for _ in range(problems)), level, tied)
    return on_problem, over_all, winner, on_problem | over_all | winner


def of_subject(
    draw: Draw, k: int, problems: int, trials: int, studies: int, chosen: str = "", sizes: Sequence[int] = ()
) -> tuple[Flags, Flags, Flags, Flags]:
    """Return which studies claim anything false of a subject, in halves and quarters of the problems, too.

    A subject that is ``chosen`` after the results is the optimizer that is lowest most often over all trials; "naive"
    tests it as if it had been named before, "counted" tests every pair, as a page does.
    """
    rng, pairs = np.random.default_rng((k, problems, trials, 7)), k * (k - 1) // 2
    values = [draw(rng, k, studies, max(sizes, default=trials)) for _ in range(problems)]
    if chosen:
        wins = np.stack([sum((of.argmin(axis=0) == place).sum(axis=1) for of in values) for place in range(k)])
        order = np.argsort(-wins, axis=0, kind="stable")
        values = [np.take_along_axis(of, order[:, :, np.newaxis], axis=0) for of in values]
    strata = [[[own[:, :size] for own, size in zip(of, sizes or [trials] * k, strict=True)]] for of in values]
    tested = pairs if chosen == "counted" else k - 1
    level = levels([sorted(sizes)[-2] if sizes else trials] * problems, tested, tested * problems)
    parts = [list(range(start, problems, step)) for step in (2, 4) for start in range(step) if problems >= 2 * step]
    if chosen == "counted":
        on_problem, over_all, _ = claims(strata, level)
        where = claims(strata, level._replace(course=level.course * 2 / k, across=0.0), parts=parts)[2]
    else:
        on_problem, over_all, where = claims(strata, level, 2 if draw is two_best else k, parts)
    return on_problem, over_all, where, on_problem | over_all | where


def by_class(draw: Draw, k: int, sizes: Sequence[int], trials: int, studies: int) -> tuple[Flags, Flags, Flags, Flags]:
    """Return which studies claim anything of a subject that equals its rivals, in classes of functions, too."""
    rng, problems = np.random.default_rng((k, *sizes, trials)), sum(sizes)
    strata = ([[*draw(rng, k, studies, trials)]] for _ in range(problems))
    level = levels([trials] * problems, k - 1, (k - 1) * problems)
    on_problem, over_all, where = claims(strata, level, parts=_places(sizes))
    return on_problem, over_all, where, on_problem | over_all | where


def but_the_first(k: int, sizes: Sequence[int], trials: int, shift: float, studies: int) -> tuple[Flags, Flags, Flags]:
    """Return which studies claim anything in the first class, where a subject equals its rivals.

    In the others it is better: what is claimed there, and over all problems, is true.
    """
    rng, problems = np.random.default_rng((k, *sizes, trials, 3)), sum(sizes)
    values = rng.standard_normal((problems, k, studies, trials))
    values[sizes[0] :, 1:] += shift
    level = levels([trials] * problems, k - 1, (k - 1) * problems)
    found = stacked([stacked([effects(of[0], of[rival]) for rival in range(1, k)]) for of in values])
    a12, ratio, smaller = map(np.asarray, found)
    alone = p_values(found)
    classes = np.array([p_of_means(Effects(a12[at], ratio[at], smaller[at])) for at in _places(sizes)])
    opened = np.array([(holm(own) <= level.across).all() for own in p_of_means(found).T])
    on_problem, where = (
        np.array(
            [
                (holm(own.ravel())[: first * (k - 1)] <= at).any()
                for own, at in zip(np.moveaxis(p, 2, 0), by, strict=True)
            ]
        )
        for p, first, by in ((alone, sizes[0], np.full(studies, level.problems)), (classes, 1, level.in_parts(opened)))
    )
    return on_problem, where, on_problem | where


def _places(sizes: Sequence[int]) -> list[list[int]]:
    ends = np.cumsum(sizes)
    return [list(range(end - size, end)) for size, end in zip(sizes, ends, strict=True)]


def of_chances(rng: np.random.Generator, chances: Floats, trials: int) -> Effects:
    """Return estimates of A12, of the shape of ``chances``, from pairs of samples that have them for truth."""
    this, other = rng.standard_normal((2, chances.size, trials))
    found = effects(this, other + np.sqrt(2) * norm.ppf(chances.clip(1e-12, 1 - 1e-12)).reshape(-1, 1))
    return Effects(*(np.broadcast_to(each, chances.size).reshape(chances.shape) for each in found))


def these(values: Sequence[float], shares: Sequence[float], problems: int, trials: int, studies: int) -> list[Flags]:
    number = np.diff(np.append(0, np.round(np.cumsum(shares) * problems).astype(int)))
    chances = np.repeat(np.array(values), number)
    truth = float(chances.mean())
    found = of_chances(np.random.default_rng(1), np.tile(chances[:, np.newaxis], (1, studies)), trials)
    low, high = intervals(mean_of(found))
    claimed = p_of_means(found) <= 0.05
    wrong = claimed & ((found.a12.mean(axis=0) > 0.5) != (truth > 0.5)) if abs(truth - 0.5) > 1e-9 else claimed
    return [wrong, (low <= truth) & (truth <= high)]


def one_problem(true: float, trials: int, studies: int, ratio: float = 10.0) -> Flags:
    this, other = np.random.default_rng(trials).standard_normal((2, studies, trials))
    shift = np.sqrt(1 + ratio**2) * norm.ppf(true)
    low, high = intervals(mean_of(stacked([effects(this, ratio * other + shift)])))
    return np.asarray((low <= true) & (true <= high))


def power(k: int, problems: int, trials: int, shift: float, spread_of: float, studies: int) -> list[Flags]:
    """Return which studies name the first of k optimizers the winner, and which do by ranks.

    The last is Wilcoxon's signed-rank test of problems against each rival, adjusted over the pairs, at half of the
    level. The others are worse by ``shift`` in the mean, by more on some problems and better on others.
    """
    rng, pairs = np.random.default_rng(1), k * (k - 1) // 2
    level = levels([trials] * problems, pairs, pairs * problems).across
    values = rng.standard_normal((problems, k, studies, trials))
    values[:, 1:] += (shift + spread_of * norm.ppf((np.arange(problems) + 0.5) / problems))[:, None, None, None]
    every = [stacked([effects(of[0], of[rival]) for of in values]) for rival in range(1, k)]
    above = np.all([found.a12.mean(axis=0) > 0.5 for found in every], axis=0)
    won = above & np.all([p_of_means(found) <= level for found in every], axis=0)
    ranks = [wilcoxon(found.a12 - 0.5, axis=0, method="approx").pvalue * pairs <= 0.025 for found in every]
    return [won, above & np.all(ranks, axis=0)]


def by_instance(variance: float, studies: int, instances: int = 5, trials: int = 5) -> list[Flags]:
    """Return which studies find a difference of one SD of runs on an instance, within instances and across them."""
    rng = np.random.default_rng(1)
    values = rng.standard_normal((2, studies, instances, trials)) * (1 - variance) ** 0.5
    values += rng.standard_normal((studies, instances, 1)) * variance**0.5
    values[1] += (1 - variance) ** 0.5
    within = stratified([effects(values[0, :, place], values[1, :, place]) for place in range(instances)])
    across = effects(values[0].reshape(studies, -1), values[1].reshape(studies, -1))
    return [p_values(found) <= 0.01 for found in (within, across)]


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000)
