"""How often each kind of claim is false, in designs chosen to mislead it, and the power of a winner.

    python validation/claims.py [STUDIES] [PART ...]    # default: 2,000 a row, all parts

Parts: equals, marks, stars, ratios, curves, power.

The functions are those of the page. In a design without a difference all optimizers of a group are equal in the sense
of A12: a run of one ends lower than a run of the other in half of the pairs, on each problem or in the mean over
problems. Columns: *winner*, an optimizer that the results name is shown to end lower than every rival; *subject*, the
first optimizer is shown to end lower or higher than an equal rival; *problem*, any pair of equals is called different
on a problem, as a share of problems; *crossed*, the studies in which a test and its interval contradict each other;
*star*, the studies whose table of running times has any; *missed*, those whose interval of the ratio of expected
running times does not hold the true one; *uncovered*, those whose band leaves the true curve anywhere.
Allowed are 0.05 and two standard errors, so 0.060 with 2,000 studies. Designs are written down before they are run.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Sequence

import bands
import numpy as np
import pandas as pd

from bench.analysis.bands import leads
from bench.analysis.comparison import inflation, over_problems
from bench.analysis.direction import ALPHA, Effects, effects, inference
from bench.analysis.ert_ratio import ert_ratios
from bench.analysis.pairwise import holm
from bench.analysis.running_time import separably_fastest
from bench.contract.typing import Flags, Floats

Draw = Callable[[np.random.Generator, int, int, int], Floats]  # optimizer, studies, runs -> values
MEDIAN = 1.6783469900166608  # of the sum of two exponential values


def normal(rng: np.random.Generator, _: int, studies: int, n: int) -> Floats:
    return rng.standard_normal((studies, n))


def spread(ratio: float) -> Draw:
    """Normal values whose spread grows from one optimizer to the next, in all by the ratio for the fifth."""
    return lambda rng, place, studies, n: ratio ** (place / 4) * rng.standard_normal((studies, n))


def cauchy(rng: np.random.Generator, place: int, studies: int, n: int) -> Floats:
    return 10.0**place * rng.standard_cauchy((studies, n))


def lognormal(rng: np.random.Generator, _: int, studies: int, n: int) -> Floats:
    return np.exp(3 * rng.standard_normal((studies, n)))


def rounded(rng: np.random.Generator, place: int, studies: int, n: int) -> Floats:
    """Three values or, of every second optimizer, five: most pairs tie."""
    return np.asarray(np.round(rng.standard_normal((studies, n)) * (1 + place % 2)).clip(-1 - place % 2, 1 + place % 2))


def optimum(rng: np.random.Generator, _: int, studies: int, n: int) -> Floats:
    """Nineteen of twenty runs at the optimum."""
    return np.exp(rng.standard_normal((studies, n))) * (rng.random((studies, n)) < 0.05)


def basins(rng: np.random.Generator, place: int, studies: int, n: int) -> Floats:
    """Two basins, and between them a single one, for every second optimizer."""
    values = rng.standard_normal((studies, n))
    return values + 50.0 * rng.choice([-1, 1], (studies, n)) if place % 2 else values


def skewed(rng: np.random.Generator, place: int, studies: int, n: int) -> Floats:
    """Exponential values, and their mirror image for the second optimizer."""
    values = rng.exponential(1.0, (studies, n))
    return MEDIAN - values if place % 2 else values


def failing(share: float) -> Draw:
    def draw(rng: np.random.Generator, _: int, studies: int, n: int) -> Floats:
        values = rng.standard_normal((studies, n))
        values[rng.random(values.shape) < share] = np.inf
        return values

    return draw


def successes(rate: float) -> Draw:
    return lambda rng, _, studies, n: (rng.random((studies, n)) >= rate).astype(np.float64)


Sizes = Sequence[int] | Callable[[int, int], int]  # of the runs of each optimizer, or by problem and optimizer

# name, draw, k, N, runs, group: how many optimizers are equal, 0 for all
EQUAL: list[tuple[str, Draw, int, int, Sizes, int]] = [
    # those of the issue and of earlier versions of this script
    ("normal", normal, 2, 6, [15] * 2, 0),
    ("normal", normal, 4, 6, [15] * 4, 0),
    ("normal", normal, 5, 24, [15] * 5, 0),
    ("normal", normal, 10, 24, [30] * 10, 0),
    ("five equal pairs", normal, 10, 6, [15] * 10, 2),
    ("ten equal pairs", normal, 20, 6, [15] * 20, 2),
    ("two best, three others", normal, 5, 18, [30] * 5, 2),
    ("spreads to 100", spread(100), 5, 1, [5] * 5, 0),
    ("spreads to 100", spread(100), 5, 24, [15] * 5, 0),
    ("success .9", successes(0.9), 5, 24, [15] * 5, 0),
    ("20% failures", failing(0.2), 5, 24, [15] * 5, 0),
    ("spreads 100:1, 5 and 51 runs", spread(100.0**4), 2, 6, [51, 5], 0),
    ("spreads 1:100, 5 and 51 runs", spread(100.0**4), 2, 6, [5, 51], 0),
    # written down for this version before any was run
    ("two problems, two runs", normal, 2, 2, [2] * 2, 0),
    ("60 problems, two runs", normal, 2, 60, [2] * 2, 0),
    ("60 problems, two runs, spreads", spread(100), 5, 60, [2] * 5, 0),
    ("20 optimizers, two problems", normal, 20, 2, [5] * 20, 0),
    ("200 runs, log-normal", lognormal, 3, 10, [200] * 3, 0),
    ("2 and 200 runs, spreads 1:100", spread(100.0**4), 2, 3, [2, 200], 0),
    ("200 and 2 runs, spreads 1:100", spread(100.0**4), 2, 3, [200, 2], 0),
    ("runs from 2 to 50, spreads", spread(100), 4, 12, lambda problem, place: 2 + (7 * problem + 17 * place) % 49, 0),
    ("Cauchy, tenfold each", cauchy, 4, 8, [15] * 4, 0),
    ("three values, five values", rounded, 4, 12, [10] * 4, 0),
    ("95% at the optimum", optimum, 3, 24, [30] * 3, 0),
    ("two basins about one", basins, 2, 6, [8] * 2, 0),
    ("two basins about one", basins, 3, 24, [15] * 3, 0),
    ("two basins about one", basins, 2, 1, [11] * 2, 0),
    ("exponential and its mirror", skewed, 2, 6, [8] * 2, 0),
    ("exponential and its mirror, 5 and 30 runs", skewed, 2, 12, [5, 30], 0),
    ("half of the runs fail", failing(0.5), 6, 24, [7] * 6, 0),
    ("three runs", normal, 3, 4, [3] * 3, 0),
    ("one problem", normal, 5, 1, [10] * 5, 0),
    ("a single run", normal, 4, 24, [1] * 4, 0),
    ("cells are missing", normal, 4, 12, lambda problem, place: 6 * ((3 * problem + place) % 7 > 0), 0),
    ("20 optimizers, 60 problems", normal, 20, 60, [5] * 20, 0),
]
CANCEL = [  # A12 by problem, whose mean is 0.5, and runs; of these the tests on problems are of true differences
    ("A12 .9 and .1 by turns", [0.9, 0.1], 5), ("A12 .9 and .1 by turns", [0.9, 0.1] * 5, 30),
    ("A12 .95 on one of ten", [0.95] + [0.45] * 9, 15), ("A12 .05 on one of ten", [0.05] + [0.55] * 9, 5),
    ("A12 1 and 0 by turns", [1.0, 0.0] * 3, 10), ("A12 .6 on four of five", [0.6] * 4 + [0.1], 51),
]  # fmt: skip
# name, times, whether all runs reach the target, k, N, n
STARS: list[tuple[str, Draw, float, int, int, int]] = [
    ("identical, log-normal times", lognormal, 1.0, 2, 12, 15),
    ("identical, log-normal times", lognormal, 1.0, 5, 24, 15),
    ("identical, half reach it", lognormal, 0.5, 2, 12, 15),
    ("identical, one in five reaches it", lognormal, 0.2, 3, 6, 51),
    ("multiples of a population", rounded, 1.0, 2, 12, 15),
    ("two shapes: two basins about one", basins, 1.0, 2, 1, 15),
    ("two shapes: two basins about one", basins, 1.0, 2, 24, 15),
    ("two shapes: two basins about one", basins, 1.0, 2, 6, 51),
    ("two shapes, half reach it", basins, 0.5, 2, 6, 30),
    ("exponential times and the mirror", skewed, 1.0, 2, 12, 15),
    ("exponential times and the mirror", skewed, 1.0, 2, 1, 51),
    ("spreads to 100", spread(100), 1.0, 5, 6, 15),
]
# name, spread of the logarithm of times, chances of success of the chosen one and of the rival, true factor, N, n
RATIOS = [
    ("all succeed", 0.7, 1.0, 1.0, 1.0, 4, 8),
    ("all succeed", 1.0, 1.0, 1.0, 1.0, 24, 15),
    ("all succeed, three times slower", 1.0, 1.0, 1.0, 3.0, 6, 15),
    ("all succeed, heavy tails", 2.0, 1.0, 1.0, 1.0, 12, 15),
    ("all succeed, two runs", 1.0, 1.0, 1.0, 1.0, 12, 2),
    ("all succeed, five runs", 1.0, 1.0, 1.0, 1.0, 6, 5),
    ("one problem", 1.0, 1.0, 1.0, 1.0, 1, 15),
    ("nine of ten succeed", 1.0, 0.9, 0.9, 1.0, 12, 15),
    ("half succeed", 1.0, 0.5, 0.5, 1.0, 12, 15),
    ("one of ten succeeds", 1.0, 0.1, 0.1, 1.0, 6, 15),
    ("nine and three of ten", 1.0, 0.9, 0.3, 1.0, 24, 15),
    ("nine and three of ten, five runs", 1.0, 0.9, 0.3, 1.0, 12, 5),
    ("all, and one of twenty", 1.0, 1.0, 0.05, 1.0, 12, 15),
    ("all, and one of twenty, 51 runs", 1.0, 1.0, 0.05, 1.0, 6, 51),
    ("nine of ten, and one of 200", 1.0, 0.9, 0.005, 1.0, 6, 15),
]
FAILURE = 20.0  # times the median time of a success, what a failure costs
POWER = [(4, 6, 15, 0.45, 0.56), (10, 24, 30, 0.18, 0.59), (2, 24, 15, 0.2, 0.66), (5, 24, 15, 0.3, 0.85)]


def main(studies: int, *chosen: str) -> None:
    print(f"{studies:,} studies a row; standard errors in brackets", flush=True)
    for part in chosen or PARTS:
        PARTS[part](studies)


def equals(studies: int) -> None:
    header("equal optimizers", "k", "N", "winner", "subject", "problem", "crossed")
    for name, draw, k, number, runs, group in EQUAL:
        row(name, k, number, *equal(draw, k, number, runs, group or k, studies))
    header("equal in the mean over problems", "N", "n", "winner", "crossed")
    for name, truth, n in CANCEL:
        row(name, len(truth), n, *cancelling(truth, n, studies))
    header("instances, most variance between them", "k", "N", "winner", "crossed")
    row("five instances, three runs on each", 3, 6, *by_instance(3, 6, 3, 5, studies))
    header("seeds shared over problems", "k", "N", "n", "winner", "seeds ignored")
    for k, number, n, correlation in ((2, 12, 15, 0.1), (3, 24, 10, 0.5), (3, 12, 15, 0.0), (2, 12, 5, 0.3)):
        row(f"correlation {correlation}", k, number, n, *by_seed(k, number, n, correlation, studies))


def marks(studies: int) -> None:
    header("signs and stars, each test at 0.05", "n", "claimed")
    for name, draw, sizes in (
        ("spreads 100:1", spread(100.0**4), (51, 5)), ("spreads 1:100", spread(100.0**4), (5, 51)),
        ("times of two shapes", basins, (15, 15)), ("times of two shapes", basins, (5, 5)),
        ("multiples of a population", rounded, (15, 15)), ("half reach it never", failing(0.5), (15, 15)),
    ):  # fmt: skip
        rng = np.random.default_rng(1)
        p = inference(effects(*(draw(rng, place, studies, n) for place, n in enumerate(sizes))), ALPHA)[2]
        row(name, "+".join(map(str, sizes)), share(p <= ALPHA))


def stars(studies: int) -> None:
    header("tables of running times", "k", "N", "n", "star")
    for name, draw, reach, k, number, n in STARS:
        rng = np.random.default_rng(1)
        row(name, k, number, n, share(np.array([starred(rng, draw, reach, k, number, n) for _ in range(studies)])))


def ratios(studies: int) -> None:
    header("ratio of expected running times", "N", "n", "missed", "by a bound")
    for name, spread_of, own, other, factor, number, n in RATIOS:
        row(name, number, n, *missed(spread_of, (own, other), factor, number, n, studies))


def curves(studies: int) -> None:
    header("band of one curve", "N", "runs", "uncovered")
    for draw, number, runs in ((bands.memoryless, 6, 5), (bands.unlike, 6, 15), (bands.rare, 1, 51)):
        outside = 1 - bands.covered(draw, number, runs, studies)[0]
        row(draw.__name__, number, runs, f"{outside:.3f} ({(outside * (1 - outside) / studies) ** 0.5:.3f})")
    header("curves of equal optimizers", "k", "N", "runs", "lead")
    for name, runs in (("easy and hard", (15, 15)), ("easy and hard, swapped", (30, 20)), ("ten to one", (50, 5))):
        row(name, 2, 2, "+".join(map(str, runs)), share(unlike_runs(runs, studies)))
    for name, draws, number, runs in (
        ("rare successes", [bands.rare] * 2, 1, 51), ("one run in fifty", [bands.hopeless] * 2, 1, 51),
        ("one run in thirty stuck", [bands.stuck] * 2, 1, 51), ("two shapes", [bands.alone, bands.together], 1, 51),
        ("fast and slow runs", [bands.smooth] * 5, 6, 15), ("rare successes", [bands.rare] * 10, 6, 15),
    ):  # fmt: skip
        rng, of = np.random.default_rng(1), {str(place): (draw, 1.0) for place, draw in enumerate(draws)}
        shown = [(leads(bands.hits_of(of, rng, number, runs), bands.GRID)["ahead"] != "").any() for _ in range(studies)]
        row(name, len(draws), number, runs, share(np.array(shown)))


def powers(studies: int) -> None:
    header("power of the winner", "k", "N", "n", "shift", "at least", "found")
    for k, number, n, shift, least in POWER:
        row("others worse by a shift", k, number, n, shift, least, share(power(k, number, n, shift, studies)))


PARTS = {"equals": equals, "marks": marks, "stars": stars, "ratios": ratios, "curves": curves, "power": powers}


def header(*names: str) -> None:
    print("\n" + names[0].ljust(46) + "".join(name.rjust(16) for name in names[1:]), flush=True)


def row(name: str, *cells: object) -> None:
    print(name.ljust(46) + "".join(str(cell).rjust(16) for cell in cells), flush=True)


def share(flags: Flags) -> str:
    """Return the share of studies, the first axis, with its standard error."""
    means = np.asarray(flags, dtype=np.float64).reshape(len(flags), -1).mean(axis=1)
    return f"{means.mean():.3f} ({means.std() / len(means) ** 0.5:.3f})"


def equal(draw: Draw, k: int, number: int, runs: Sizes, group: int, studies: int) -> tuple[str, str, str, str]:
    """Return the four shares of a design in which groups of optimizers are equal; each group is worse than the last."""
    rng, pairs = np.random.default_rng(1), list(itertools.combinations(range(k), 2))
    alike = np.array([one // group == two // group for one, two in pairs])
    found, on_problem = [], []
    for problem in range(number):
        size = [runs(problem, place) if callable(runs) else runs[place] for place in range(k)]
        values = [draw(rng, place, studies, size[place]) + 4.0 * (place // group) for place in range(k)]
        there = [place for place, (one, two) in enumerate(pairs) if min(size[one], size[two])]
        estimates = {place: effects(*(values[each] for each in pairs[place])) for place in there}
        if len(there) == len(pairs):
            found.append(estimates)
        p, among = np.array([inference(each, ALPHA)[2] for each in estimates.values()]), alike[there]
        on_problem.append([bool((holm(own)[among] <= ALPHA).any()) for own in p.T])
    over = [over_problems([[own[place]] for own in found]) for place in range(len(pairs))]
    winner, crossed = named(over, pairs, k)
    first = [place for place, (one, two) in enumerate(pairs) if not one and alike[place]]
    subject = np.any([inference(over[place], ALPHA / (k - 1))[2] <= ALPHA / (k - 1) for place in first], axis=0)
    return share(winner), share(subject), share(np.array(on_problem).T), share(crossed)


def named(over: Sequence[Effects], pairs: Sequence[tuple[int, int]], k: int) -> tuple[Flags, Flags]:
    """Return in which studies the leader is named, and in which a test and its interval contradict each other."""
    studies = len(over[0].a12)
    chance, lower, crossed = np.full((k, studies), 0.0), np.zeros((k, studies)), np.zeros(studies, dtype=bool)
    for (one, two), each in zip(pairs, over, strict=True):
        low, high, p = inference(each, ALPHA)
        chance[one] += each.a12
        chance[two] += 1 - each.a12
        lower[one] += (p <= ALPHA) & (each.a12 > 0.5)
        lower[two] += (p <= ALPHA) & (each.a12 < 0.5)
        crossed |= (p <= ALPHA) != ((low > 0.5) | (high < 0.5))
    leader = chance.argmax(axis=0)
    return lower[leader, np.arange(studies)] == k - 1, crossed


def cancelling(truth: Sequence[float], n: int, studies: int) -> tuple[str, str]:
    """Return how often one of two is named whose mean A12 is 0.5: runs are uniform, and win with the chance."""
    rng, found = np.random.default_rng(1), []
    for chance in truth:
        this, other = rng.random((2, studies, n))
        found.append([effects(this, other + shift_of(chance))])
    winner, crossed = named([over_problems(found)], [(0, 1)], 2)
    return share(winner), share(crossed)


def shift_of(chance: float) -> float:
    """Return by how much one of two uniform values is larger that are lower with this chance."""
    return 1 - (2 * (1 - chance)) ** 0.5 if chance > 0.5 else (2 * chance) ** 0.5 - 1


def by_instance(k: int, number: int, n: int, instances: int, studies: int) -> tuple[str, str]:
    """Return how often one of equal optimizers is named whose runs are compared within instances that differ much."""
    rng, pairs, found = np.random.default_rng(1), list(itertools.combinations(range(k), 2)), []
    for _ in range(number):
        values = rng.standard_normal((instances, k, studies, n)) + 5 * rng.standard_normal((instances, 1, studies, 1))
        found.append([[effects(values[i, one], values[i, two]) for i in range(instances)] for one, two in pairs])
    over = [over_problems([own[place] for own in found]) for place in range(len(pairs))]
    winner, crossed = named(over, pairs, k)
    return share(winner), share(crossed)


def by_seed(k: int, number: int, n: int, correlation: float, studies: int) -> tuple[str, str]:
    """Return how often one of equal optimizers is named, whose runs of a seed correlate over problems.

    The seed of a run is its number on every problem. The second share is that of the test that does not know of seeds.
    """
    rng, pairs = np.random.default_rng(1), list(itertools.combinations(range(k), 2))
    shown, naive = np.zeros((2, studies), dtype=bool)
    seeds = [[[np.arange(n), 1000 + np.arange(n)]]] * number
    for study in range(studies):
        values = np.sqrt(1 - correlation) * rng.standard_normal((number, k, n))
        values += np.sqrt(correlation) * rng.standard_normal((1, k, n))
        lower, apart = np.zeros((2, k), dtype=int)
        for one, two in pairs:
            found = over_problems([[effects(own[None, one], own[None, two])] for own in values])
            factor, freedom = inflation([[[own[one], own[two]]] for own in values], seeds)
            better = one if found.a12[0] > 0.5 else two
            lower[better] += inference(found._replace(ratio=found.ratio * factor), ALPHA, freedom)[2][0] <= ALPHA
            apart[better] += inference(found, ALPHA)[2][0] <= ALPHA
        shown[study], naive[study] = lower.max() == k - 1, apart.max() == k - 1
    return share(shown), share(naive)


def starred(rng: np.random.Generator, draw: Draw, reach: float, k: int, number: int, n: int) -> bool:
    """Return whether a table of running times to one target on each problem has a star."""
    times = np.array([draw(rng, place, number, n) for place in range(k)]).ravel()
    index = pd.MultiIndex.from_product([[f"o{place}" for place in range(k)], range(number), range(n)])
    hits = index.to_frame(index=False, name=["optimizer", "problem", "trial"])
    times = times - times.min() + 1
    reached = rng.random(len(times)) < reach
    hits = hits.assign(tau=1.0, target=1.0, evaluations=np.where(reached, times, np.inf), spent=times.max())
    return len(separably_fastest(hits)) > 0


def missed(
    spread_of: float, chances: tuple[float, float], factor: float, number: int, n: int, studies: int
) -> tuple[str, str]:
    """Return the share of studies whose interval misses the true ratio, and that of problems with a bound.

    Times are log-normal, and tenfold longer from one problem to the next one; the ratio is the same on all problems.
    """
    rng, out, bounded = np.random.default_rng(1), np.zeros(studies, dtype=bool), np.zeros(studies)
    own, other = (expected(spread_of, chance) for chance in chances)
    problem, trial = np.repeat(np.arange(number), n), np.tile(np.arange(n), number)
    for study in range(studies):
        parts = []
        for label, chance, slower in zip("ab", chances, (1.0, factor), strict=True):
            unit = slower * 10.0 ** (problem % 6)
            times = unit * np.exp(spread_of * rng.standard_normal(number * n))
            reached = (rng.random(number * n) < chance) & (times < FAILURE * unit)
            columns = {"evaluations": np.where(reached, times, np.inf), "spent": FAILURE * unit}
            parts.append(pd.DataFrame({"problem": problem, "optimizer": label, "trial": trial} | columns))
        for found in ert_ratios(pd.concat(parts, ignore_index=True), "a", ["b"]).itertuples():
            out[study] = found.low > factor * other / own or found.high < factor * other / own
            bounded[study] = found.bounded / found.problems
    return share(out), f"{bounded.mean():.3f}"


def expected(spread_of: float, chance: float) -> float:
    """Return the true expected running time of log-normal times, cut at what a failure costs."""
    times = np.exp(spread_of * np.random.default_rng(2).standard_normal(2_000_000))
    success = chance * float((times < FAILURE).mean())
    return float(times[times < FAILURE].mean()) + (1 - success) / success * FAILURE


def unlike_runs(runs: tuple[int, int], studies: int) -> Flags:
    """Return which studies show a lead of one of two equal optimizers on an easy and a hard problem.

    One has ``runs`` on the easy and on the hard one, the other one the same numbers the other way round.
    """
    rng, shown = np.random.default_rng(1), np.zeros(studies, dtype=bool)
    grid = np.geomspace(1, 1000, 12)
    for study in range(studies):
        parts = [
            pd.DataFrame({
                "problem": problem, "optimizer": optimizer, "trial": range(n), "tau": 1.0,
                "evaluations": rng.exponential(scale, n),
            })
            for optimizer, of in (("a", runs), ("b", runs[::-1]))
            for problem, scale, n in zip(("easy", "hard"), (10, 3000), of, strict=True)
        ]  # fmt: skip
        shown[study] = bool((leads(pd.concat(parts, ignore_index=True), grid)["ahead"] != "").any())
    return shown


def power(k: int, number: int, n: int, shift: float, studies: int) -> Flags:
    """Return which studies name the first of k optimizers, the others of which are worse by a shift."""
    rng, pairs = np.random.default_rng(1), list(itertools.combinations(range(k), 2))
    found = []
    for _ in range(number):
        values = rng.standard_normal((k, studies, n)) + shift * (np.arange(k) > 0)[:, np.newaxis, np.newaxis]
        found.append([effects(values[one], values[two]) for one, two in pairs])
    return named([over_problems([[own[place]] for own in found]) for place in range(len(pairs))], pairs, k)[0]


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000, *sys.argv[2:])
