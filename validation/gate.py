"""False alarms, false passes and power of ``bench gate`` by both of its rules, by simulation.

    python validation/gate.py [NULL] [SHIFTED]        # default: 500 null and 200 shifted pairs of each kind

A pair is an old and a new version on N problems whose values are normal, bimodal, heavy-tailed, and, where versions are
equal, in a third of the trials equal (the optimum), in turn. The new version is made worse without any assumption about
the values: with a chance q, a trial ends with the worst one of k values, which makes A12 = 0.5 + q (k - 1) / (2 k + 2)
where no values are equal. The pairs "of stored trials" are random halves of the 30 trials of an optimizer on the 18
problems of results/thesis, which are no version of anything: they differ by chance alone. A pass is one on average, or,
with ``--every-problem``, one on each problem. Rates have their standard errors.
"""

import csv
import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.analysis.noninferiority import MARGIN, compare_samples

STORED = Path(__file__).parents[1] / "results" / "thesis" / "trials.csv"
WIDE = 0.2  # a margin that each of twelve problems can be held to
SEVEN, NINE = (0.8, 3), (1.0, 9)  # share and number of values that make A12 = 0.7 and 0.9

Samples = dict[str, tuple[np.ndarray, np.ndarray]]


def main() -> None:
    null, shifted = (int(value) for value in (*sys.argv[1:], *("500", "200")[len(sys.argv) - 1 :]))
    rng = np.random.default_rng(18)
    stored = stored_cells()
    kinds: list[tuple[str, float, int, Callable[[], Samples]]] = [
        (f"equal, {n} trials", MARGIN, null, lambda n=n: pair(rng, n)) for n in (10, 30, 60)
    ]
    kinds.append(("equal, of stored trials, 15", MARGIN, null, lambda: halves(rng, stored)))
    kinds += [
        (f"A12 = 0.55 on every problem, {n} trials", MARGIN, null, lambda n=n: pair(rng, n, every=(0.3, 2)))
        for n in (10, 30)
    ]
    for a12 in (0.6, 0.65):
        worse = 6 * (a12 - 0.5), 2
        kinds += [
            (f"A12 = {a12} on every problem, {n} trials", MARGIN, shifted, lambda n=n, q=worse: pair(rng, n, every=q))
            for n in (10, 30)
        ]
    kinds += [
        (f"A12 = 0.7 on one of {number}, {n} trials", MARGIN, shifted, lambda n=n, k=number: pair(rng, n, k, one=SEVEN))
        for number in (12, 24)
        for n in (10, 30, 60)
    ]
    kinds += [
        (f"A12 = 0.9 on one of 12, {n} trials", MARGIN, shifted, lambda n=n: pair(rng, n, one=NINE)) for n in (10, 30)
    ]
    kinds += [(f"equal, {n} trials", WIDE, shifted, lambda n=n: pair(rng, n)) for n in (60, 100)]
    kinds += [
        (f"A12 = 0.7 on one of 12, {n} trials", WIDE, null, lambda n=n: pair(rng, n, one=SEVEN)) for n in (60, 100)
    ]
    print(f"{'':40} margin  pairs  {'pass on average':>15}  {'pass on every':>15}  {'worse':>15}")
    for name, margin, pairs, draw in kinds:
        samples = ({problem: [both] for problem, both in draw().items()} for _ in range(pairs))
        found = [compare_samples(each, margin, every=True) for each in samples]
        worse = [each.outcome == "worse" for each in found]
        average = [each.high <= each.bound and each.outcome != "worse" for each in found]
        rates = [rate(each) for each in (average, [each.passed for each in found], worse)]
        print(f"{name:40} {margin:6} {pairs:6,}  {rates[0]:>15}  {rates[1]:>15}  {rates[2]:>15}", flush=True)


def rate(found: list[bool]) -> str:
    """Return a share with its standard error, that of two more cases of either kind: none seen is not none at all."""
    adjusted = (np.sum(found) + 2) / (len(found) + 4)  # Agresti and Coull 1998, The American Statistician 52
    return f"{100 * np.mean(found):.1f}% +- {100 * np.sqrt(adjusted * (1 - adjusted) / (len(found) + 4)):.1f}"


def pair(
    rng: np.random.Generator,
    n: int,
    problems: int = 12,
    every: tuple[float, int] | None = None,
    one: tuple[float, int] | None = None,
) -> Samples:
    """Return n values of both versions by problem, new ones worse on every problem or on one: share, worst of k."""
    samples = {}
    for number in range(problems):
        kind = number % (4 if every is None else 3)
        old, new = values(rng, kind, n), values(rng, kind, n)
        worse = every or (one if number == 0 else None)
        if worse is not None:
            worst = np.max([new, *(values(rng, kind, n) for _ in range(worse[1] - 1))], axis=0)
            new = np.where(rng.random(n) < worse[0], worst, new)
        samples[f"problem {number}"] = old, new
    return samples


def values(rng: np.random.Generator, kind: int, n: int) -> np.ndarray:
    """Return n final values: normal, bimodal, log-normal with a long tail, or with a third at the optimum."""
    z = rng.standard_normal(n)
    if kind == 1:
        return np.where(rng.random(n) < 0.4, 5 + z / 10, z / 10)
    if kind == 2:
        return np.exp(3 * z)
    return z if kind == 0 else np.where(rng.random(n) < 1 / 3, 0.0, np.exp(z))


def stored_cells() -> dict[str, dict[str, np.ndarray]]:
    """Return the stored final values by optimizer and problem."""
    found: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    with STORED.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found[row["optimizer"]][row["problem"]].append(float(row["fun"]))
    return {name: {label: np.array(own) for label, own in cells.items()} for name, cells in found.items()}


def halves(rng: np.random.Generator, stored: dict[str, dict[str, np.ndarray]]) -> Samples:
    """Return random halves of the trials of one optimizer, by problem."""
    cells = stored[str(rng.choice(list(stored)))]
    mixed = {label: rng.permutation(own) for label, own in cells.items()}
    return {label: (own[: len(own) // 2], own[len(own) // 2 :]) for label, own in mixed.items()}


if __name__ == "__main__":
    main()
