"""How often declared looks, and looks at unadjusted p-values, find a difference; and the trials that looks save.

Every simulated study is one problem: equal optimizers, or one that is better than its equal rivals by a shift or in the
share of trials that end in the good one of two basins. The rule is that of a run: tests of A12 = 0.5, the level spent
over the looks, Holm's method over all pairs, and a cell is stopped once all of its pairs are decided.

    python validation/looks.py [STUDIES]        # default: 2,000 a row
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pandas as pd

from bench.analysis import ALPHA, holm
from bench.analysis.direction import effects, p_values
from bench.analysis.looks import decide
from bench.typing import Floats

Draw = Callable[[np.random.Generator, tuple[int, int, int]], Floats]


def equal(rng: np.random.Generator, shape: tuple[int, int, int]) -> Floats:
    return rng.standard_normal(shape)


def shifted(rng: np.random.Generator, shape: tuple[int, int, int]) -> Floats:
    values = rng.standard_normal(shape)
    values[:, 0] -= 1.2  # A12 = 0.80
    return values


def basins(rng: np.random.Generator, shape: tuple[int, int, int]) -> Floats:
    missed = np.full(shape[1], 0.7)[:, np.newaxis]
    missed[0] = 0.2  # A12 = 0.75
    return rng.normal(0, 0.1, shape) + 5 * (rng.random(shape) < missed)


def naive(values: Floats, looks: tuple[int, ...], find: bool) -> Floats:
    """Return whether any look at p-values adjusted over pairs alone shows a difference, or one with the first."""
    one, other = np.triu_indices(values.shape[1], 1)
    found = np.zeros((len(values), len(one)), dtype=bool)
    for look in looks:
        p = [p_values(effects(values[:, i, :look], values[:, j, :look])) for i, j in zip(one, other, strict=True)]
        found |= np.array([holm(each) for each in np.transpose(p)]) <= ALPHA
    return found[:, one == 0].all(axis=1) if find else found.any(axis=1)


def study(draw: Draw, looks: tuple[int, ...], optimizers: int, studies: int, find: bool) -> tuple[float, float, float]:
    """Return the shares of studies that show a difference by the rule and by naive looks, and the share of trials."""
    values = draw(np.random.default_rng(1), (studies, optimizers, looks[-1]))
    index = pd.MultiIndex.from_product([range(studies), range(optimizers), range(looks[-1])])
    frame = index.to_frame(index=False, name=["problem", "optimizer", "trial"]).assign(status="ok", fun=values.ravel())
    frame = frame.astype({"problem": "category", "optimizer": "category"})
    found = decide(frame, looks, ALPHA * studies)  # which it divides by the problems: here each is a study of its own
    pairs = found.pairs["p"].to_numpy().reshape(studies, -1)
    significant = np.array([holm(each) for each in pairs]) <= ALPHA
    one, _ = np.triu_indices(optimizers, 1)
    kept = significant[:, one == 0].all(axis=1) if find else significant.any(axis=1)
    made = sum(found.stopped.values()) + looks[-1] * (studies * optimizers - len(found.stopped))
    return float(kept.mean()), float(naive(values, looks, find).mean()), made / (studies * optimizers * looks[-1])


def main(studies: int) -> None:
    print(f"{studies} studies a row; standard error of 5%: {np.sqrt(0.05 * 0.95 / studies):.1%}")
    print(f"{'truth':10} {'looks':20} {'optimizers':>10} {'with looks':>10} {'naive':>7} {'trials made':>11}")
    for name, draw in (("equal", equal), ("shifted", shifted), ("basins", basins)):
        for looks in ((10, 20, 30), (10, 20, 30, 60), (20, 40, 60, 80, 100)):
            for optimizers in (2, 4):
                kept, loose, made = study(draw, looks, optimizers, studies, name != "equal")
                shown = ", ".join(map(str, looks))
                print(f"{name:10} {shown:20} {optimizers:10} {kept:10.1%} {loose:7.1%} {made:11.0%}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000)
