"""Inside a trial process: load the plug-ins, warm up, make one trial, and look what it left behind."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import threading
import tomllib
import traceback
import warnings
from collections.abc import Iterator
from functools import lru_cache
from time import monotonic
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from bench import environment
from bench.errors import BenchError
from bench.names import printable
from bench.problem import Problem
from bench.process import Pulse
from bench.seeds import global_states
from bench.study import Study, Trial
from bench.trial import as_row, search
from bench.words import spell

STILL_ASKING = 87
"""The exit code of a process that an optimizer held up, asking on and on after its budget was spent."""

_REFUSALS = 10  # one is all that an optimizer needs to see
_FAREWELL = 0.1  # seconds that threads have to end after their trial

Row = dict[str, Any]


def failed(reason: str) -> Row:
    """Return the row of a trial that failed."""
    return {"status": "failed", "error": printable(reason, 4000)}


def check(study_text: str, *, pulse: Pulse) -> tuple[dict[str, str], dict[str, str]] | str:  # noqa: ARG001
    """Return what :meth:`bench.study.Study.check` does, or in words why the study cannot be run."""
    try:
        return _study(study_text).check()
    except BenchError as error:
        return str(error)


def describe(study_text: str, *, pulse: Pulse) -> str:
    """Return what :func:`bench.environment.machine` says of this process, with all the study's plug-ins loaded."""
    study = _study(study_text)
    plugins: list[object] = []
    for load, entries in ((study.optimizer, study.optimizers), (study.problem, study.problems)):
        for entry in entries:
            pulse(0, 1)
            with contextlib.suppress(Exception):  # its trials will say what is wrong
                plugins.append(load(entry.label))
    threadpool_limits(limits=1)
    return json.dumps(environment.machine(environment.modules(plugins)))


def prepare(study_text: str, problem: str, optimizer: str, *, pulse: Pulse) -> None:
    """Make one discarded, short trial for each kind of problem and optimizer: no trial shall wait for a compiler.

    Pulses while numba compiles, which may take longer than a trial is allowed to.
    """
    with contextlib.suppress(Exception):  # the trial itself will say what is wrong
        study = _study(study_text)
        loaded, chosen = _problem(study_text, problem), study.optimizer(optimizer)
        key = study_text, type(loaded), optimizer
        if key in _warm:
            return
        _warm.add(key)
        with _compilations(pulse), _contained():
            budget = min(study.budget, 3 * chosen.minimum_budget)
            search(loaded, chosen, budget, 0, _refuse)
    threadpool_limits(limits=1)  # of what was loaded only now; the environment has told the others


def make(study_text: str, trial: Trial, *, pulse: Pulse) -> tuple[Row, bool]:  # noqa: ARG001 - a trial is not disturbed
    """Make one trial; whatever it raises becomes its row.

    Returns:
        the trial's row, and whether the process may go on to make others.
    """
    states, threads = global_states(), set(threading.enumerate())
    try:
        study = _study(study_text)
        problem, optimizer = _problem(study_text, trial.problem), study.optimizer(trial.optimizer)
        with _contained():
            result = search(problem, optimizer, study.budget, trial.seed, _refuse)
        row = as_row(result, problem.variables)
    except BaseException as error:  # a plug-in may raise anything, and it costs only its own cell
        row = failed(f"{spell(error)}\n{traceback.format_exc(limit=-3)}")
    left = _living(set(threading.enumerate()) - threads)
    if row["status"] == "ok":
        if left:
            row = failed(
                f"left {left} threads running, in the time of the trials after it; have them ended before minimize "
                "returns or its budget is spent"
            )
        elif changed := [name for name, state in global_states().items() if state != states[name]]:
            row = failed(
                f"used the global random state of {' and '.join(changed)}, so its seed does not repeat it; draw from "
                "the rng that minimize is given"
            )
    return row, not left


@lru_cache(maxsize=4)
def _study(text: str) -> Study:
    return Study.from_dict(tomllib.loads(text))


@lru_cache(maxsize=256)
def _problem(study_text: str, label: str) -> Problem:
    return _study(study_text).problem(label)


_warm: set[tuple[str, type, str]] = set()


@contextlib.contextmanager
def _contained() -> Iterator[None]:
    """Put back what a plug-in may change for those after it."""
    with np.errstate(), warnings.catch_warnings(), contextlib.chdir("."):
        yield


def _refuse(number: int) -> None:
    """End this process when an optimizer does not take the end of its budget for an answer: nothing else stops it."""
    if number > _REFUSALS:
        os._exit(STILL_ASKING)


def _living(threads: set[threading.Thread]) -> int:
    """Return how many of the threads do not end by themselves in a moment."""
    deadline = monotonic() + _FAREWELL
    for thread in threads:
        thread.join(max(0.0, deadline - monotonic()))
    return sum(thread.is_alive() for thread in threads)


@contextlib.contextmanager
def _compilations(pulse: Pulse) -> Iterator[None]:
    """Pulse at the start and the end of whatever numba compiles, where anything is compiled by it."""
    if "numba" not in sys.modules:
        yield
        return
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:  # noqa: ARG002
            pulse(0, 1)

        on_end = on_start

    with event.install_listener("numba:compile", Listener()):
        yield
