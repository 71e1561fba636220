"""What an optimizer is by itself, whatever the study: whether it favours the centre of the box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from bench.errors import BenchError
from bench.folder import Folder
from bench.optimizer import Optimizer
from bench.problem import Floats, FunctionProblem
from bench.seeds import trial_seed
from bench.study import Study
from bench.trial import solve

LIMIT = 10.0  # a geometric mean ratio of errors above this is a bias (Kudela 2022)
SHIFT = 0.1  # of the box, in every variable
FLOOR = 1e-8  # errors below this are no longer told apart
HALF_WIDTH = 100.0  # of the box [-100, 100]


@dataclass(frozen=True)
class Diagnosis:
    """The outcome of one check of an optimizer.

    Attributes:
        check: what was checked.
        passed: whether the optimizer is free of the trait.
        figure: the number it was judged by.
        finding: one sentence.
    """

    check: str
    passed: bool
    figure: float
    finding: str

    def as_dict(self) -> dict[str, Any]:
        """Return the diagnosis as JSON can hold it."""
        return asdict(self)


def centre_bias(optimizer: Optimizer, *, dimension: int = 7, runs: int = 10, seed: int = 0) -> Diagnosis:
    """Return how much lower the errors are when the optimum lies at the centre of the box.

    Each of five functions is minimised with its optimum at the centre and with the same function moved by 10 % of
    the box, ``runs`` times each, with 10,000 evaluations or 50 generations, whichever is more. The figure is the
    geometric mean of the ratios of errors, moved over centred; errors are taken as at least 1e-8. An unbiased method
    has a ratio near 1, one that draws its points to the centre a large one (Kudela, Nature Machine Intelligence 4,
    2022).

    Raises:
        BenchError: when the optimizer fails on one of the functions.
    """
    budget = max(10_000, 50 * optimizer.minimum_budget)
    logarithms = []
    for name, function in FUNCTIONS.items():
        errors = {}
        for place, shift in (("centred", 0.0), ("moved", SHIFT * 2 * HALF_WIDTH)):
            problem = _problem(name, function, dimension, shift)
            errors[place] = [
                _error(problem, optimizer, budget, trial_seed(seed, f"{name} {place}", "centre bias", run))
                for run in range(runs)
            ]
        logarithms.append(np.log(errors["moved"]).mean() - np.log(errors["centred"]).mean())
    ratio = float(np.exp(np.mean(logarithms)))
    passed = ratio <= LIMIT
    finding = (
        f"errors are {ratio:.2g} times as high when the optimum is moved from the centre of the box by "
        f"{SHIFT:.0%} of it ({'below' if passed else 'above'} the limit of {LIMIT:g})"
    )
    return Diagnosis("centre bias", passed, ratio, finding)


def _error(problem: FunctionProblem, optimizer: Optimizer, budget: int, seed: int) -> float:
    try:
        found = solve(problem, optimizer, budget=budget, seed=seed).fun
    except BenchError:
        raise
    except Exception as error:  # a plug-in may raise anything
        raise BenchError(f"the optimizer failed on {problem.name}: {type(error).__name__}: {error}") from error
    return max(found, FLOOR) if np.isfinite(found) else np.finfo(float).max


def _problem(name: str, function: Callable[[Floats], Floats], dimension: int, shift: float) -> FunctionProblem:
    bound = [HALF_WIDTH] * dimension
    return FunctionProblem(lambda x: function(x - shift), [-HALF_WIDTH] * dimension, bound, name=name, optimum=0.0)


def _sphere(z: Floats) -> Floats:
    return np.asarray((z**2).sum(axis=1))


def _ellipsoid(z: Floats) -> Floats:
    weights = 10 ** np.linspace(0, 6, z.shape[1])
    return np.asarray((weights * z**2).sum(axis=1))


def _rastrigin(z: Floats) -> Floats:
    y = z * 0.0512
    return np.asarray((y**2 - 10 * np.cos(2 * np.pi * y) + 10).sum(axis=1))


def _ackley(z: Floats) -> Floats:
    y = z * 0.32
    radius = np.sqrt((y**2).mean(axis=1))
    waves = np.cos(2 * np.pi * y).mean(axis=1)
    return np.asarray(20 - 20 * np.exp(-0.2 * radius) + np.e - np.exp(waves))


def _griewank(z: Floats) -> Floats:
    y = z * 6.0
    return np.asarray((y**2).sum(axis=1) / 4000 - np.cos(y / np.sqrt(np.arange(1, z.shape[1] + 1))).prod(axis=1) + 1)


# The classic unimodal and multimodal functions, each on its usual domain scaled to the box; all are 0 at the origin.
FUNCTIONS: dict[str, Callable[[Floats], Floats]] = {
    "sphere": _sphere, "ellipsoid": _ellipsoid, "Rastrigin": _rastrigin, "Ackley": _ackley, "Griewank": _griewank,
}  # fmt: skip


def diagnose(folder: Folder, n_jobs: int = -1) -> tuple[dict[str, list[Diagnosis]], dict[str, str]]:
    """Diagnose every optimizer of a study with its own options, and note the outcome in the folder for reports.

    Returns:
        the diagnoses by optimizer label, and why an optimizer could not be diagnosed, by label.
    """
    study = folder.study()
    outcomes = Parallel(n_jobs=n_jobs)(delayed(_diagnosis)(study, each.label) for each in study.optimizers)
    found: dict[str, list[Diagnosis]] = {}
    failed: dict[str, str] = {}
    for entry, outcome in zip(study.optimizers, outcomes, strict=True):
        if isinstance(outcome, Diagnosis):
            found[entry.label] = [outcome]
        else:
            failed[entry.label] = outcome
    folder.note_checks({label: [each.as_dict() for each in those] for label, those in found.items()})
    return found, failed


def _diagnosis(study: Study, label: str) -> Diagnosis | str:
    """Return an optimizer's diagnosis, or why there is none: one that fails must not cost the others theirs."""
    try:
        return centre_bias(study.optimizer(label))
    except BenchError as error:
        return str(error)
