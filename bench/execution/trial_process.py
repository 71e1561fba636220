"""The functions called in a trial process: load plug-ins, warm up, make trials."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tomllib
import traceback
from collections.abc import Iterator
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

from threadpoolctl import threadpool_limits

from bench.errors import BenchError
from bench.problem import Problem
from bench.sandbox import side_effects
from bench.sandbox.messages import describe_error
from bench.sandbox.process import Pulse
from bench.sandbox.side_effects import SideEffects
from bench.storage import provenance
from bench.study import Fingerprints, Study
from bench.text import printable
from bench.trial import Row, Trial, as_row, search

STILL_ASKING = 87
"""The exit code of a process whose optimizer kept asking for values after its budget was spent."""

_REFUSALS = 10  # of BudgetExhausted; one suffices for an optimizer that lets it pass


def failed(reason: str) -> Row:
    """Return the row of a trial that failed."""
    return {"status": "failed", "error": printable(reason, 4000)}


def check(study_text: str, *, pulse: Pulse) -> Fingerprints | str:
    """Return the result of :meth:`bench.study.Study.check`, or a sentence on why the study cannot be run."""
    try:
        with _pulsing(pulse):
            return _study(study_text).check()
    except BenchError as error:
        return printable(str(error), 4000)


def describe_machine(study_text: str, *, pulse: Pulse) -> tuple[str, bool]:
    """Load all plug-ins of the study; return this process's record as JSON, and whether it may make trials."""
    study = _study(study_text)
    plugins: list[object] = []
    with _pulsing(pulse):
        for load, entries in ((study.optimizer, study.optimizers), (study.problem, study.problems)):
            for entry in entries:
                pulse(0, 1)
                with contextlib.suppress(BaseException):  # its trials will report the error
                    plugins.append(load(entry.label))
    threadpool_limits(limits=1)
    return json.dumps(provenance.machine(provenance.modules(plugins))), side_effects.set_baseline()


def load(study_text: str, problem: str, optimizer: str, *, pulse: Pulse) -> None:
    """Load the problem and the optimizer of a cell; pulses while modules are imported."""
    with contextlib.suppress(BaseException), _pulsing(pulse):  # the trial itself will report the error
        _problem(study_text, problem)
        pulse(0, 1)
        _study(study_text).optimizer(optimizer)
    threadpool_limits(limits=1)  # for libraries loaded just now; the environment set the limit of the others
    side_effects.set_baseline()  # where it fails, the next trial reports so


def warm_up(study_text: str, problem: str, optimizer: str, *, pulse: Pulse) -> None:
    """Make and discard one short trial for each kind of problem and optimizer, so that no trial waits for a compiler.

    Pulses while modules are imported and numba compiles, which may take longer than a trial is allowed to.
    """
    with contextlib.suppress(BaseException):  # the trial itself will report the error
        study = _study(study_text)
        loaded, chosen = _problem(study_text, problem), study.optimizer(optimizer)
        key = study_text, type(loaded), optimizer
        if key in _warm:
            return
        _warm.add(key)
        with _pulsing(pulse), SideEffects():
            budget = min(study.budget, 3 * chosen.minimum_budget)
            search(loaded, chosen, budget, 0, _end_if_stuck)
    threadpool_limits(limits=1)  # for libraries that only a run loads


def make(study_text: str, trial: Trial, *, pulse: Pulse) -> tuple[Row, bool]:  # noqa: ARG001 - would disturb a trial
    """Make one trial; return its row, also after an exception, and whether the process may make other trials."""
    effects = SideEffects()
    try:
        study = _study(study_text)
        problem, optimizer = _problem(study_text, trial.problem), study.optimizer(trial.optimizer)
        with effects:
            result = search(problem, optimizer, study.budget, trial.seed, _end_if_stuck)
        row = as_row(result, problem.variables)
    except BaseException as error:  # a plug-in may raise anything; only its own trial fails
        row = failed(f"{describe_error(error)}\n{traceback.format_exc(limit=-3)}")
    if row["status"] == "ok" and (reason := _why_void(effects)):
        row = failed(reason)
    return row, not effects.lasting


def _why_void(effects: SideEffects) -> str:
    """Return why the side effects of a trial void it, "" where they do not."""
    running = [kind for count, kind in ((effects.threads, "threads"), (effects.processes, "processes")) if count]
    if running:
        return (
            f"left {' and '.join(running)} running, in the time of the trials after it; end them before "
            "minimize returns or its budget is spent"
        )
    if effects.random:
        return (
            f"used the global random state of {' and '.join(effects.random)}, so its seed does not repeat it; draw "
            "from the rng that minimize is given"
        )
    return ""


@lru_cache(maxsize=4)
def _study(text: str) -> Study:
    return Study.from_dict(tomllib.loads(text))


@lru_cache(maxsize=256)
def _problem(study_text: str, label: str) -> Problem:
    return _study(study_text).problem(label)


_warm: set[tuple[str, type, str]] = set()


def _end_if_stuck(number: int) -> None:
    """End this process when an optimizer keeps ignoring BudgetExhausted: nothing else stops it."""
    if number > _REFUSALS:
        os._exit(STILL_ASKING)


@contextlib.contextmanager
def _pulsing(pulse: Pulse) -> Iterator[None]:
    """Pulse at every import of a module and at every step of a compilation by numba."""
    finder: Any = SimpleNamespace(find_spec=lambda *_: pulse(0, 1))  # finds no module, but is asked for each
    sys.meta_path.insert(0, finder)
    try:
        with _pulsing_compilations(pulse):
            yield
    finally:
        with contextlib.suppress(ValueError):
            sys.meta_path.remove(finder)


@contextlib.contextmanager
def _pulsing_compilations(pulse: Pulse) -> Iterator[None]:
    """Pulse at the start and the end of every step of a compilation by numba, where it is loaded."""
    if "numba" not in sys.modules:
        yield
        return
    from numba.core import event

    class Listener(event.Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:  # noqa: ARG002
            pulse(0, 1)

        on_end = on_start

    with event.install_listener("numba:run_pass", Listener()):
        yield
