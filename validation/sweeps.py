"""How often a sweep is said to depend on a parameter that has no effect, and what it finds, by simulation.

    python validation/sweeps.py [STUDIES]        # default: 1,000 of each kind

A study sweeps parameters on problems, with trials of each combination. In the null designs no parameter has an effect,
or all but the last one do; a claim on a parameter without effect is wrong. "Matters" is the share of studies with a
wrong claim that a parameter matters, "worse" with one that a value is worse than the best one, "across" with one that
values differ across problems. In the designs with an effect they are the shares with a right claim on the last
parameter. With "spreads" the last parameter changes the spread of the trials and no A12 from 0.5: it matters, so only
"worse" and "across" are wrong there. Each test has 199 permutations in place of up to 4,999, on whose number no rate of
wrong claims depends.
"""

import sys
from itertools import product

import numpy as np
import pandas as pd

from bench.analysis import ALPHA, factors
from bench.analysis.factors import contributions
from bench.study.sweep import Sweep


def draw(kind: str, rng: np.random.Generator, levels: tuple[int, ...], problem: int, trials: int) -> np.ndarray:
    """Return the values of the trials of a combination, by the places of its values."""
    first, *_, last = levels
    match kind.removeprefix("found: "):
        case "ties":
            return np.round(np.maximum(rng.normal(size=trials), 0))
        case "skewed":
            return np.exp(3 * rng.standard_t(3, size=trials))
        case "failures by the first":
            return np.where(rng.random(trials) < 0.15 + 0.25 * first, np.inf, rng.normal(size=trials))
        case "others interact":  # and change the spread, in ways that differ from problem to problem
            place = sum(levels[:-1]) % 2 * (-1) ** problem
            return 2 * place + (1 + 3 * first) * rng.normal(size=trials)
        case "spreads":
            return 4.0**last * rng.normal(size=trials)
        case "a shift of 0.5 SD":
            return 0.5 * last + rng.normal(size=trials)
        case "crossed":  # the better value of the last parameter depends on the first one: neither is in the mean
            return 0.7 * (-1) ** (first + last) + rng.normal(size=trials)
    return rng.normal(size=trials)


KINDS: list[tuple[str, tuple[int, ...], int, int, set[int]]] = [
    # kind, numbers of values, problems, trials, parameters that have an effect
    ("normal", (2, 2), 2, 5, set()),
    ("normal", (3, 3, 3), 6, 5, set()),
    ("normal, one trial", (3, 3), 6, 1, set()),
    ("normal, one problem", (3, 2), 1, 15, set()),
    ("ties", (2, 3), 2, 10, set()),
    ("skewed", (2, 3), 2, 10, set()),
    ("values 2 and 8", (2, 8), 2, 5, set()),
    ("failures by the first", (3, 2), 2, 10, {0}),
    ("failures by the first", (3, 2), 8, 5, {0}),
    ("others interact", (2, 2, 3), 2, 10, {0, 1}),
    ("others interact", (2, 2, 3), 8, 5, {0, 1}),
    ("spreads", (2, 3), 2, 15, {1}),
    ("spreads", (2, 3), 8, 5, {1}),
    ("found: a shift of 0.5 SD", (2, 2), 2, 10, {1}),
    ("found: a shift of 0.5 SD", (2, 2), 8, 10, {1}),
    ("found: crossed", (2, 2), 2, 10, {1}),
]


def main() -> None:
    studies = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000
    factors.PERMUTATIONS = (199, 199)
    print(f"{'claims, ' + format(studies, ',') + ' studies a row':26}{'values':>10}{'N':>4}{'n':>4}", end="")
    print("".join(f"{name:>16}" for name in ("matters", "worse", "across")))
    for kind, sizes, problems, trials, effect in KINDS:
        rng, claims = np.random.default_rng(48), np.zeros(3)
        for _ in range(studies):
            tests = study(rng, kind, sizes, problems, trials)
            claims += claimed(tests, kind, [str(place) for place in range(len(sizes)) if place not in effect], sizes)
        shares = claims / studies
        errors = np.sqrt(shares * (1 - shares) / studies)
        cells = "".join(f"{f'{share:.3f} ({error:.3f})':>16}" for share, error in zip(shares, errors, strict=True))
        print(f"{kind:26}{' x '.join(map(str, sizes)):>10}{problems:>4}{trials:>4}{cells}", flush=True)


def study(rng: np.random.Generator, kind: str, sizes: tuple[int, ...], problems: int, trials: int) -> pd.DataFrame:
    """Return the tests of a simulated sweep."""
    values = {str(place): tuple(map(str, range(size))) for place, size in enumerate(sizes)}
    sweep = Sweep("o", values, {levels: f"o{levels}" for levels in product(*values.values())})
    rows = [
        (f"p{problem}", label, value, "ok" if np.isfinite(value) else "failed")
        for problem in range(problems)
        for levels, label in sweep.labels.items()
        for value in draw(kind, rng, tuple(map(int, levels)), problem, trials)
    ]
    frame = pd.DataFrame(rows, columns=["problem", "optimizer", "fun", "status"])
    return contributions(frame, sweep).tests.set_index("factor")


def claimed(tests: pd.DataFrame, kind: str, null: list[str], sizes: tuple[int, ...]) -> list[bool]:
    """Return whether any parameter of interest is said to matter, to have a worse value, to differ across problems."""
    last = str(len(sizes) - 1)
    mattering = null if not kind.startswith("found") else [last]
    directed = [*null, last] if kind == "spreads" else mattering
    return [
        bool((tests.loc[mattering, "p_here"] <= ALPHA).any()),
        any(map(bool, tests.loc[directed, "worse"])),
        bool(((tests["p_holm"] <= ALPHA) & (tests["note"] == "")).loc[directed].any()),
    ]


if __name__ == "__main__":
    main()
