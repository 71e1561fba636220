"""False alarms and power of ``bench gate``, by simulation.

    python performance/gate.py [NULL] [SHIFTED]        # default: 1,000 null and 200 shifted pairs of each kind

A pair is an old and a new version on 12 problems whose values are normal, bimodal, heavy-tailed, and in a third of the
trials equal (the optimum), in turn. The new version is made worse without any assumption about the values: with a
chance q, a trial ends with the worse one of two values, which makes A12 = 0.5 + q / 6 where no values are equal; for a
loss on one problem, with the worst of nine, A12 = 0.9. The pairs "of stored trials" are random halves of the 30 trials
of an optimizer on the 18 problems of results/thesis, which are no version of anything: they differ by chance alone.
"""

import csv
import sys
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.analysis.noninferiority import compare_samples

PROBLEMS = 12
STORED = Path(__file__).parents[1] / "results" / "thesis" / "trials.csv"

Samples = dict[str, tuple[np.ndarray, np.ndarray]]


def main() -> None:
    null, shifted = (int(value) for value in (*sys.argv[1:], *("1000", "200")[len(sys.argv) - 1 :]))
    rng = np.random.default_rng(18)
    stored = stored_cells()
    kinds: list[tuple[str, int, int, Callable[[], Samples]]] = [
        (f"equal, {n} trials", n, null, lambda n=n: pair(rng, n)) for n in (10, 30, 60)
    ]
    kinds.append(("equal, of stored trials", 15, null, lambda: halves(rng, stored)))
    kinds += [
        (f"at the margin, A12 = 0.55, {n} trials", n, null, lambda n=n: pair(rng, n, share=0.3, ties=False))
        for n in (10, 30)
    ]
    for a12 in (0.6, 0.65):
        share = 6 * (a12 - 0.5)
        kinds += [
            (f"worse, A12 = {a12}, {n} trials", n, shifted, lambda n=n, q=share: pair(rng, n, share=q, ties=False))
            for n in (10, 30)
        ]
    kinds += [
        (f"worse on one problem, A12 = 0.9, {n} trials", n, shifted, lambda n=n: pair(rng, n, one=True))
        for n in (10, 30)
    ]
    print(f"{'':50} pairs   pass  undecided  worse")
    for name, _, pairs, draw in kinds:
        found = Counter(compare_samples(draw()).outcome for _ in range(pairs))
        shares = [100 * found[outcome] / pairs for outcome in ("pass", "undecided", "worse")]
        print(f"{name:50} {pairs:5,} {shares[0]:5.1f}% {shares[1]:9.1f}% {shares[2]:5.1f}%", flush=True)


def pair(rng: np.random.Generator, n: int, share: float = 0.0, ties: bool = True, one: bool = False) -> Samples:
    """Return n values of both versions by problem; ``share`` of the new trials are the worse one of two."""
    samples = {}
    for number in range(PROBLEMS):
        kind = number % (4 if ties else 3)
        old, new = values(rng, kind, n), values(rng, kind, n)
        new = np.where(rng.random(n) < share, np.maximum(new, values(rng, kind, n)), new)
        if one and number == 0:
            new = np.max([new, *(values(rng, kind, n) for _ in range(8))], axis=0)
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
