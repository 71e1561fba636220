"""Run one optimizer once on one problem: in this process, or apart from it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from copy import copy
from dataclasses import replace
from inspect import signature
from os import PathLike
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from bench.contract.numbers import require_seed
from bench.contract.objective import OnEvaluation
from bench.contract.optimizer import Optimizer, defaults, settings
from bench.contract.problem import Problem
from bench.contract.typing import Options
from bench.execution.job import Task
from bench.execution.journal import DROPPED, Journal
from bench.execution.side_by_side import evaluated
from bench.execution.supervisor import Supervisor
from bench.execution.warming import warm_optimizer, warm_problem
from bench.helpers.errors import BenchError, nearest
from bench.helpers.parsing import JsonObject
from bench.helpers.text import count
from bench.plugins import loading
from bench.plugins.loading import OptimizerLike, title
from bench.plugins.observing import hash_of
from bench.plugins.packing import pack
from bench.sandbox.messages import describe_error
from bench.sandbox.server import end_if_stuck
from bench.study import Study
from bench.study.budget import Budget
from bench.study.initial import known_points, with_initial
from bench.study.rules import KEYS as RULES
from bench.study.rules import Rules
from bench.trial.columns import Row
from bench.trial.scoring import scored
from bench.trial.trial import UNASKED, Result, Trial, numbers, search


def solve(
    problem: str | Problem | Callable[..., ArrayLike],
    optimizer: OptimizerLike,
    *,
    budget: int | str,
    bounds: Sequence[tuple[float, float]] | None = None,
    seed: int = 0,
    on_evaluation: OnEvaluation | None = None,
    initial: ArrayLike | str | None = None,
    output: str | PathLike[str] | None = None,
    **study: object,
) -> Result:
    """Run one optimizer once on one problem.

    Where the problem's ``describe`` fails, the result has no metrics, and a warning gives the reason.

    Example:
        >>> bench.solve("signature-12", "gwo", budget=60_000, seed=1).fun
        >>> bench.solve(lambda x: (x**2).sum(), "cma-es", bounds=[(-5, 5)] * 3, budget="100 * d").x

    Args:
        problem: a problem, the name of one, or a function with bounds (:class:`bench.FunctionProblem`).
        optimizer: the name of one, an optimizer or a class of them, a function ``(objective, rng)``, a class with
            ``ask`` and ``tell``, or a class ``X(budget, dim)`` whose instances are called with the function.
        budget: evaluations it may spend, or a multiple of the dimension such as ``"100 * d"``; it may be less than one
            generation.
        bounds: of a function, a pair (lower, upper) for each variable.
        seed: repeats the run exactly; the ``seed`` of a study's row repeats that trial.
        on_evaluation: called after each evaluation with its number from 1, the (d,) point, its value (+inf of an
            infeasible point) and the lowest value so far; it may raise :class:`bench.StopRun`.
        initial: (k, d) points that are known, with which the run begins, or the name of a CSV file of them.
        output: a folder in which the evaluations are noted, so that the same call goes on after an interruption
            (:mod:`bench.execution.journal`); of a problem without noise.
        study: further keys of a study (:class:`bench.study.rules.Rules`): ``constraints``, ``on_error``,
            ``evaluation_timeout``, ``time``, ``final_target``, ``stop_at`` and ``parallel``.

    Raises:
        BenchError: for an unknown problem, optimizer or rule, bounds that are not a box, a budget below 1, a rule that
            cannot be, and for a noisy problem where its points are to be evaluated by other processes.
        ProblemError: where the problem raises; its ``raised`` is what the problem raised.
    """
    known = {*signature(solve).parameters, *RULES} - {"study", "journal"}
    for name in study:
        if name not in known:
            raise BenchError(f"solve has no setting {name!r}{nearest(name, known)}")
    rules = Rules(**study)
    loaded = loading.as_problem(problem, bounds)
    chosen = loading.as_optimizer(optimizer)
    require_seed("'seed'", seed)
    spent = Budget.read(budget, "'budget'").evaluations(loaded.dimension)
    if initial is not None:
        loaded = with_initial(copy(loaded), known_points(initial, "of this call"))
    minimized = scored(loaded, rules.constraints, rules.on_error)
    good = rules.goal(minimized)
    journal = None
    if output is not None and not loaded.noisy:
        usual = defaults(chosen)
        given = settings(chosen).items() if chosen is optimizer else ()
        changed = (f" {name}={value}" for name, value in given if repr(value) != repr(usual.get(name)))
        label = title(optimizer) + "".join(changed)
        key = Trial(loaded.name, label, 0, seed).columns | {"budget": spent, "variables": [*loaded.variables]}
        Path(output).mkdir(parents=True, exist_ok=True)
        journal = Journal(Path(output), key, _about(loaded), limit=rules.evaluation_timeout, always=True)
    if isinstance(optimizer, str):
        warm(minimized, chosen, spent)
    # Results and times must not depend on the number of BLAS threads.
    with threadpool_limits(limits=1), evaluated(minimized, *rules.evaluation, journal) as answering:
        found = search(answering, chosen, spent, seed, end_if_stuck, rules.time, good, on_evaluation)
        try:
            metrics = numbers(answering.describe(found.x.copy()))
        except Exception as error:  # what was found is not lost by it
            warnings.warn(f"{loaded.name} does not describe its best point: {describe_error(error)}", stacklevel=2)
            metrics = {}
    if journal and journal.dropped:
        warnings.warn(DROPPED.format(count(journal.dropped, "evaluation")), stacklevel=2)
    if found.usage.unasked:
        warnings.warn(UNASKED.format(title(optimizer)), stacklevel=2)
    return replace(found, metrics=metrics)


def _about(problem: Problem) -> JsonObject:
    """Return what decides the values of a problem of this session, as far as it can be known: its code and files."""
    words = problem.name.replace("'", "").removeprefix("command:").split()
    about = {word: hash_of(word) for word in words if Path(word).is_file()}
    with suppress(BenchError):
        about["code"] = pack(problem).digest
    return about


def warm(problem: Problem, optimizer: Optimizer, budget: int) -> None:
    """Import and compile what a run needs, so that it counts in no time; the run itself reports errors."""
    with suppress(Exception, SystemExit), threadpool_limits(limits=1):
        warm_problem(problem, budget)
    with suppress(Exception, SystemExit), threadpool_limits(limits=1):
        warm_optimizer(optimizer, problem.lower, problem.upper, problem.integer, budget)


def solve_untrusted(problem: Options, optimizer: Options, *, seed: int, **settings: Any) -> Row:
    """Run code that nobody trusts as one trial, and return its row; nothing is loaded in this process.

    Args:
        problem: its entry in a study: ``name`` and options.
        optimizer: likewise.
        seed: repeats the run.
        settings: ``budget``, ``constraints`` and further keys, as in a study.

    Raises:
        BenchError: for plug-ins that cannot be loaded, settings that cannot be, and without bubblewrap.
    """
    require_seed("the seed", seed)
    lists = {"problems": [problem], "optimizers": [optimizer]}
    study = Study.from_dict({"name": "solve", "trials": 1} | lists | settings, "of this command")
    trial = Trial(study.problems[0].label, study.optimizers[0].label, 0, seed)
    with closing(Supervisor(Task.of(study, untrusted=True))) as supervisor:
        supervisor.load()
        return supervisor.make(trial)
