"""False and true verdicts of ``bench reproduce`` on cells of published tables, by simulation.

    python validation/reproduce.py [TABLES]           # default: 1000 tables of 72 cells a row

Of each cell, n values are drawn and printed as mean and SD with four digits, with and without best, median and worst;
m further values are ours. Where both are of one distribution, every "differs" is false: the first part counts the
tables of 72 such cells with at least one, for designs chosen to mislead tests of means, and for draws from the thesis's
stored trials. Beside the product's test are those that it replaces. The second part is the power of a cell among 72,
and how often means that are one SD apart are called alike, or where few of our runs fail by far: what a sample without
a failure cannot show, so "alike" is no claim that means are near. Rates have their standard errors.
"""

import csv
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy import stats

from bench.reproduce.table import Printed
from bench.reproduce.verdict import compare

CELLS, ALPHA = 72, 0.05
STORED = Path(__file__).parents[1] / "results" / "thesis" / "trials.csv"


def lognormal(sigma):
    return lambda rng, shape: np.exp(sigma * rng.standard_normal(shape))


def mixed(share, one, other):
    return lambda rng, shape: np.where(rng.random(shape) < share, one(rng, shape), other(rng, shape))


def constant(value):
    return lambda _, shape: np.full(shape, float(value))


def normal(rng, shape):
    return 10 + rng.standard_normal(shape)


DESIGNS = {
    "normal": normal,
    "uniform": lambda rng, shape: rng.random(shape),
    "exponential": lambda rng, shape: rng.exponential(size=shape),
    "log-normal, sigma 1": lognormal(1),
    "log-normal, sigma 2": lognormal(2),
    "log-normal, sigma 4": lognormal(4),
    "Pareto, index 1.2": lambda rng, shape: rng.pareto(1.2, shape),
    "half zeros, else log-normal, sigma 2": mixed(0.5, constant(0), lognormal(2)),
    "nine in ten zeros": mixed(0.9, constant(0), lognormal(1)),
    "a floor below which 64% lie": lambda rng, shape: np.maximum(lognormal(2)(rng, shape), 2.0),
    "two values, 50:50": mixed(0.5, constant(0), constant(1)),
    "two values, 3:97": mixed(0.03, constant(1), constant(0)),
    "two basins, 1e-8 and 100": mixed(
        0.8, lambda r, s: 1e-8 * lognormal(1)(r, s), lambda r, s: 100 * lognormal(1)(r, s)
    ),
    "one run in 100 fails by 1000 SD": mixed(0.99, normal, lambda rng, shape: 1000 + normal(rng, shape)),
    "whole numbers, Poisson of mean 2": lambda rng, shape: rng.poisson(2.0, shape).astype(float),
}
SIZES = ((3, 3), (5, 5), (10, 10), (30, 30), (51, 51), (30, 10), (51, 5), (10, 51))
SHIFTED = {
    "normal, by 0.5 SD": (normal, lambda x: x + 0.5),
    "normal, by 1 SD": (normal, lambda x: x + 1),
    "normal, by 1.5 SD": (normal, lambda x: x + 1.5),
    "log-normal, sigma 1, times 2": (lognormal(1), lambda x: 2 * x),
    "log-normal, sigma 1, times 4": (lognormal(1), lambda x: 4 * x),
    "log-normal, sigma 2, times 10": (lognormal(2), lambda x: 10 * x),
    "log-normal, sigma 2, times 100": (lognormal(2), lambda x: 100 * x),
    "log-normal, sigma 2, by 1/100": (lognormal(2), lambda x: x / 100),
    "two basins: 20% instead of 80% of runs in the better": (
        DESIGNS["two basins, 1e-8 and 100"], lambda x: np.where(x < 1e-3, 1e8 * x, np.where(x > 1e-3, 1e-8 * x, x)),
    ),
}  # fmt: skip


def rounded(x):
    """Return numbers as printed with four digits."""
    with np.errstate(divide="ignore"):
        unit = 10.0 ** (np.floor(np.log10(np.abs(x))) - 3)
    unit = np.where(x == 0, 0.0, unit)
    return Printed(np.where(x == 0, 0.0, np.round(x / np.where(unit, unit, 1)) * unit), unit, "")


def printed(x, order):
    numbers = {"mean": rounded(x.mean(axis=-1)), "sd": rounded(x.std(axis=-1, ddof=1))}
    if order:
        numbers |= {"best": rounded(x.min(axis=-1)), "median": rounded(np.median(x, axis=-1))}
        numbers["worst"] = rounded(x.max(axis=-1))
    return numbers


def rivals(theirs, ours):
    """Return the p of Welch's and of Student's test from summary values, and of Student's with our SD for both."""
    (m, s, n), (k, t, o) = ((x.mean(axis=-1), x.std(axis=-1, ddof=1), x.shape[-1]) for x in (theirs, ours))
    with np.errstate(all="ignore"):
        tests = [stats.ttest_ind_from_stats(m, s, n, k, t, o, equal_var=equal).pvalue for equal in (False, True)]
        tests.append(2 * stats.t.sf(np.abs(m - k) / (t * np.sqrt(1 / n + 1 / o)), o - 1))
    return [np.where(m == k, 1.0, np.nan_to_num(p, nan=0.0)) for p in tests]


def per_table(p):
    """Return the share of tables with a false "differs", in percent with its error: Holm's first step decides."""
    return rate((p.reshape(-1, CELLS) <= ALPHA / CELLS).any(axis=1))


def rate(hits):
    share = hits.mean()
    return f"{100 * share:5.1f} ± {100 * max((share * (1 - share) / hits.size) ** 0.5, 1 / hits.size):.1f}%"


def stored():
    cells = defaultdict(list)
    with STORED.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            cells[row["problem"], row["optimizer"]].append(float(row["fun"]))
    return [np.array(values) for values in cells.values()]


def from_stored(cells):
    """Return a design that draws from a stored cell's trials, another cell in each of a table's."""

    def draw(rng, shape):
        chosen = np.array([cells[number % len(cells)] for number in range(shape[0])])
        return np.take_along_axis(chosen, rng.integers(chosen.shape[1], size=shape), axis=1)

    return draw


def main() -> None:
    tables = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    rng = np.random.default_rng(49)
    designs = DESIGNS | {"the thesis's stored trials": from_stored(stored())}
    print(f"tables of {CELLS} cells with a false 'differs', {tables} of each kind")
    print("| design | runs | trials | mean, SD | and best, median, worst | no SD | Welch | Student | by our SD |")
    print("|-|-|-|-|-|-|-|-|-|")
    worst = defaultdict(list)
    for name, draw in designs.items():
        for runs, trials in SIZES:
            theirs, ours = draw(rng, (tables * CELLS, runs)), draw(rng, (tables * CELLS, trials))
            lowest = 0.0 if theirs.min() >= 0 else -np.inf
            found = [compare(printed(theirs, order), runs, ours, lowest) for order in (False, True)]
            found.append(compare({"mean": printed(theirs, False)["mean"]}, runs, ours, lowest))
            shown = [per_table(p) for p in (*(each.p for each in found), *rivals(theirs, ours))]
            for kind, text in zip(("mean, SD", "order", "no SD"), shown, strict=False):
                worst[kind].append((float(text.split()[0]), name, runs, trials))
            print(f"| {name} | {runs} | {trials} | {' | '.join(shown)} |", flush=True)
    print({kind: max(rows) for kind, rows in worst.items()})
    print("\npower: cells that differ at 0.05 / 72; and 'alike' by the same cells")
    print("| ours | runs and trials | mean, SD | and best, median, worst | alike |")
    print("|-|-|-|-|-|")
    for name, (draw, change) in SHIFTED.items():
        for runs in (10, 30, 51):
            theirs, ours = draw(rng, (20_000, runs)), change(draw(rng, (20_000, runs)))
            p, near, _ = compare(printed(theirs, False), runs, ours, 0.0)
            q = compare(printed(theirs, True), runs, ours).p
            shown = rate(p <= ALPHA / CELLS), rate(q <= ALPHA / CELLS), rate(near & (p > ALPHA / CELLS))
            print(f"| {name} | {runs} | {' | '.join(shown)} |", flush=True)
    print("\n'alike' with 30 runs and trials: of equal cells, and of cells one SD apart; and the same without an SD")
    print("| errors | equal | one SD higher | equal, no SD | one SD higher, no SD |")
    print("|-|-|-|-|-|")
    for name, draw in designs.items():
        theirs, ours = draw(rng, (20_000, 30)), draw(rng, (20_000, 30))
        away = draw(rng, (500_000, 1)).std()
        shown = [
            rate(compare({key: numbers[key] for key in keys}, 30, values, 0.0).near)
            for numbers in (printed(theirs, False),)
            for keys in (("mean", "sd"), ("mean",))
            for values in (ours, ours + away)
        ]
        print(f"| {name} | {' | '.join(shown)} |", flush=True)
    print("\n'alike' with as many runs as trials, where a share of our runs fails by 1000 SD")
    print("| share | 10 runs | 30 runs | 51 runs |")
    print("|-|-|-|-|")
    for share in (0.0, 0.01, 0.03, 0.1):
        failing = mixed(1 - share, normal, lambda rng, shape: 1000 + normal(rng, shape))
        cells = [(printed(normal(rng, (20_000, n)), False), n, failing(rng, (20_000, n))) for n in (10, 30, 51)]
        shown = [rate(found.near & (found.p > ALPHA / CELLS)) for found in (compare(*cell, 0.0) for cell in cells)]
        print(f"| {share:.0%} | {' | '.join(shown)} |", flush=True)


if __name__ == "__main__":
    main()
