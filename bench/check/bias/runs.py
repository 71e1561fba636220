"""Run an optimizer on functions and on noise, and keep what the diagnosis of biases needs."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import BrokenProcessPool
from numpy.typing import NDArray

from bench.check.bias.functions import FUNCTIONS, function, noise
from bench.errors import BenchError
from bench.optimizer import Optimizer
from bench.problem import Floats
from bench.sandbox.messages import describe_error
from bench.seeds import trial_seed
from bench.trial import solve

GENERATIONS = 50  # of a run, at least: a bias of the moves needs time to show
FUNCTION_BUDGET = 10_000  # evaluations of a function, at least
NOISE_BUDGET = 1_000  # evaluations of noise, at least: without a field ``agents`` a generation counts as one evaluation

NOISE = "noise"
PLACES = ("centred", "moved")
BOXES = {"[0, 1]": (0.0, 1.0), "[-1, 1]": (-1.0, 1.0)}
"""The boxes of the noise. The origin is a corner of the first, the box of the toolbox BIAS, and the centre of the
second, so that a method that is drawn to the origin shows it in one of them."""


@dataclass(frozen=True)
class RunSummary:
    """The record of one run; points are shares of the box, 0 at the lower and 1 at the upper bounds.

    Attributes:
        best: the lowest value.
        x: (d,) where it was found.
        first: (m, d) the points of the first generation, fewer where the run ended earlier.
        clamped: the share of all evaluated coordinates that lay exactly on a bound.
        course: a hash of all points in the order of their evaluation.
    """

    best: float
    x: Floats
    first: Floats
    clamped: float
    course: bytes


@dataclass(frozen=True)
class Runs:
    """The runs from which an optimizer is judged.

    Attributes:
        centred: by function, those with the optimum at the centre of the box; each has a seed of its own.
        moved: the same with the optimum moved by 10 % of the box.
        noise: those on noise, by box; their seeds are adjacent numbers in each, and each has noise of its own.
    """

    centred: dict[str, list[RunSummary]]
    moved: dict[str, list[RunSummary]]
    noise: dict[str, list[RunSummary]]


def make_runs(
    optimizer: Optimizer, *, dimension: int = 7, runs: int = 10, noise_runs: int = 100, n_jobs: int = 1, seed: int = 0
) -> Runs:
    """Run an optimizer on every function, centred and moved, ``runs`` times each, and on noise, ``noise_runs`` a box.

    A run has 50 generations, but at least 10,000 evaluations of a function and 1,000 of noise.

    Raises:
        BenchError: when the optimizer fails, or ends a worker process.
    """
    counts = dict.fromkeys([(name, place) for name in FUNCTIONS for place in PLACES], runs)
    counts |= dict.fromkeys([(NOISE, box) for box in BOXES], noise_runs)
    tasks = [(*problem, run) for problem, count in counts.items() for run in range(count)]
    try:
        done = Parallel(n_jobs=n_jobs)(delayed(_run)(optimizer, dimension, seed, *task) for task in tasks)
    except BrokenProcessPool as error:
        raise BenchError("the optimizer ended its worker process (killed, out of memory, or by an exit)") from error
    made: dict[tuple[str, str], list[RunSummary]] = {problem: [] for problem in counts}
    for (name, place, _), run in zip(tasks, done, strict=True):
        made[name, place].append(run)
    centred, moved = ({name: made[name, place] for name in FUNCTIONS} for place in PLACES)
    return Runs(centred, moved, {box: made[NOISE, box] for box in BOXES})


def _run(optimizer: Optimizer, dimension: int, seed: int, name: str, place: str, run: int) -> RunSummary:
    """Make one run; its seed depends on its problem and number alone, so that other runs do not change it."""
    generation, label = optimizer.minimum_budget, f"{name} {place}"
    if name == NOISE:
        problem = noise(BOXES[place], dimension, trial_seed(seed, label, "values", run))
        budget, own = max(NOISE_BUDGET, GENERATIONS * generation), trial_seed(seed, label, "structural bias", 0) + run
    else:
        problem = function(name, dimension, moved=place == "moved")
        budget, own = max(FUNCTION_BUDGET, GENERATIONS * generation), trial_seed(seed, label, "centre bias", run)
    try:
        found = solve(problem, optimizer, budget=budget, seed=own)
    except BenchError:
        raise
    except (Exception, SystemExit) as error:  # a plug-in may raise anything
        raise BenchError(f"the optimizer failed on {name}: {describe_error(error)}") from error
    points = problem.points
    return RunSummary(
        best=found.fun,
        x=problem.share(found.x),
        first=problem.share(points[:generation]),
        clamped=float(on_bound(problem.share(points)).mean()),
        course=hashlib.sha256(points.tobytes()).digest(),
    )


def on_bound(x: Floats) -> NDArray[np.bool_]:
    """Return where points, as shares of the box, lie exactly on a bound, as a clip leaves them in these boxes."""
    return np.asarray((x == 0) | (x == 1))
