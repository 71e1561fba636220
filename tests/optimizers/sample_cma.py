"""The runs of pycma that ``cma-es-fast`` is held to; ``python tests/optimizers/sample_cma.py`` makes samples/pycma.csv.

Its first line names the version of pycma. A row is a run of ``cma-es``: the best value after ten generations
(``early``), the best after the cell's ``generations`` (``best``), and the evaluations until it stopped, or until the
cell's ``patience`` in generations was over (``evaluations``).
"""

from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from bench import FunctionProblem, load_problem, solve
from optimizers.cma_es import CMAES

D, SEEDS = 7, range(200)
FILE = Path(__file__).parent / "samples" / "pycma.csv"


def mirror(d):
    """Return the (d, d) reflection at the diagonal, which no coordinate axis survives."""
    return np.eye(d) - 2 / d


def sphere(x):
    return ((x - np.linspace(-4, 5, D)) ** 2).sum(axis=1)


def ellipsoid(x):
    return (10 ** np.linspace(0, 6, D) * ((x - np.linspace(-3, 3, D)) @ mirror(D)) ** 2).sum(axis=1)


def rosenbrock(x):
    return (100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2).sum(axis=1)


def rastrigin(x):
    y = x - np.linspace(-2, 2.5, D)
    return (y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1)


PROBLEMS = {
    "sphere": FunctionProblem(sphere, [-10] * D, [10] * D),
    "ellipsoid": FunctionProblem(ellipsoid, [-5] * D, [5] * D),
    "rosenbrock": FunctionProblem(rosenbrock, [-5] * D, [10] * D),
    "rastrigin": FunctionProblem(rastrigin, [-5.12] * D, [5.12] * D),
    "signature-12": load_problem("signature-12", unit="rpm"),
}


class Cell(NamedTuple):
    """A function and a population, compared after some generations; ``patience`` beyond that shows when runs stop."""

    function: str
    agents: int
    generations: int
    patience: int


DEFAULT = CMAES().population(D)

CELLS = [
    Cell("sphere", DEFAULT, 100, 400),
    Cell("ellipsoid", DEFAULT, 150, 150),
    Cell("rosenbrock", DEFAULT, 150, 150),
    Cell("rastrigin", DEFAULT, 60, 400),
    Cell("signature-12", DEFAULT, 100, 100),
    Cell("sphere", 300, 25, 25),
    Cell("ellipsoid", 300, 30, 30),
    Cell("rosenbrock", 300, 40, 40),
    Cell("rastrigin", 300, 40, 40),
    Cell("signature-12", 300, 40, 40),
]


def run(cell, optimizer, seed):
    """Return the row of one run."""
    result = solve(PROBLEMS[cell.function], optimizer, budget=cell.agents * cell.patience, seed=seed)
    early, best = result.trace.at([10 * cell.agents, cell.generations * cell.agents])
    return {
        "function": cell.function, "agents": cell.agents, "seed": seed,
        "early": early, "best": best, "evaluations": result.nfev,
    }  # fmt: skip


def load():
    """Return the version of pycma that the file was made with, and its rows."""
    with FILE.open(encoding="utf-8") as lines:
        made_with = lines.readline().split()[-1]
        return made_with, pd.read_csv(lines)


def main():
    rows = [run(cell, CMAES(agents=cell.agents), seed) for cell in CELLS for seed in SEEDS]
    with FILE.open("w", encoding="utf-8", newline="\n") as lines:
        lines.write(f"# cma {version('cma')}\n")
        pd.DataFrame(rows).to_csv(lines, index=False, float_format="%.6g", lineterminator="\n")


if __name__ == "__main__":
    main()
