"""Draw the reference's final bests, with which those of the compiled optimizers are compared.

    python tests/optimizers/sample.py

Writes ``samples/reference.csv`` beside this file: a row a run, its final best with every digit. Cells that are there
are kept, so an interrupted drawing goes on where it ended; after a change of reference.py, remove the file first. The
longest loops are compiled, which takes hours off; test_distributions.py draws some of the rows again, uncompiled.
"""

import csv
from pathlib import Path

import reference
from functions import AGENTS, BOXES, FUNCTIONS, GENERATIONS, VARIANTS, D
from numba import njit

FILE = Path(__file__).with_name("samples") / "reference.csv"
RUNS = 200
CELLS = [(name, *variant) for variant in VARIANTS for name in FUNCTIONS] + [("sphere", "da", "synchronous")]
FIRST_SEED = 1_000_000  # and each cell's seeds are a million on: none is another cell's, nor one of the tests' own


def main() -> None:
    for name in ("walk", "grasshoppers", "is_neighbour", "dragonfly"):
        setattr(reference, name, njit(getattr(reference, name)))
    FILE.parent.mkdir(exist_ok=True)
    if not FILE.exists():
        FILE.write_text("function,algorithm,variant,seed,best\n")
    with FILE.open(newline="") as file:
        drawn = {(row["function"], row["algorithm"], row["variant"]) for row in csv.DictReader(file)}
    for number, cell in enumerate(CELLS, start=1):
        if cell in drawn:
            continue
        name, algorithm, variant = cell
        f, seeds = FUNCTIONS[name], range(FIRST_SEED * number, FIRST_SEED * number + RUNS)
        value = njit(f)
        bests = [
            reference.final_best(value, *BOXES[f], D, algorithm, variant, seed, AGENTS, GENERATIONS) for seed in seeds
        ]
        with FILE.open("a", newline="") as file:
            for seed, best in zip(seeds, bests, strict=True):
                file.write(f"{name},{algorithm},{variant},{seed},{best!r}\n")
        print(*cell, flush=True)


if __name__ == "__main__":
    main()
