"""The functions called in the processes of a run: load plug-ins, warm up, make a trial, evaluate its best point again.

Their answers are JSON values; :mod:`bench.execution.answers` checks them.
"""

from __future__ import annotations

import base64
import contextlib
import traceback
from contextlib import AbstractContextManager, closing, nullcontext
from functools import cache
from math import inf
from pathlib import Path

from threadpoolctl import threadpool_limits

from bench.contract.objective import integer_flags, scanner
from bench.contract.problem import Problem
from bench.contract.seeds import streams
from bench.execution import apart
from bench.execution.answers import Box
from bench.execution.journal import Journal
from bench.execution.side_by_side import evaluated, require_possible
from bench.execution.warming import warm_optimizer, warm_problem
from bench.helpers.errors import PROBLEM_FAILED, BenchError, ProblemError
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.plugins import observing, packing
from bench.plugins.from_file import located
from bench.plugins.inputs import Inputs, named
from bench.plugins.observing import Signature, reading
from bench.plugins.packing import Objects
from bench.sandbox.server import end_if_stuck
from bench.sandbox.side_effects import SideEffects, reset_random
from bench.storage import provenance
from bench.study import Study
from bench.trial import scoring
from bench.trial.trial import Cost, Result, Trial, doubt, measured, numbers, result, search


def begin(study: Study, held: Objects, output: str, known: dict[str, tuple[str, Signature]]) -> None:
    """Set the study of all other calls in this process and its copies, and observe from now on what they read.

    Args:
        study: the study.
        held: its plug-ins that are objects of a session.
        output: the folder of results.
        known: hashes of large files by path, with their signatures.
    """
    global _study, _output
    _study, _output = study, output
    packing.held.update(held)
    observing.observe(output, known)


def hold(held: Objects) -> None:
    """Take further objects in the place of names of the study."""
    packing.held.update(held)


def check_problems() -> JsonObject:
    """Load all problems; return their dimensions, the files of their modules and the machine.

    The machine's record is that of :func:`bench.storage.provenance.machine`. Where one cannot be loaded, return a
    sentence on why.
    """

    def load(label: str) -> Problem:
        with reading("problem", label):
            return _problem(label)

    try:
        with reading("problem"):
            dimensions = _study.dimensions(load)
            for label in dimensions:
                require_possible(_problem(label), *_study.rules.evaluation)
        return {"dimensions": dimensions, "machine": provenance.machine(), "modules": observing.modules()}
    except BenchError as error:
        return {"error": printable(str(error), 4000)}


def check_optimizers(labels: list[str], dimensions: dict[str, int]) -> JsonObject:
    """Load the optimizers of one module; return the files of modules and the machine, as for problems."""
    try:
        with reading("optimizer"):
            _study.check_optimizers(labels, dimensions)
        return {"machine": provenance.machine(), "modules": observing.modules()}
    except BenchError as error:
        return {"error": printable(str(error), 4000)}


def load_problem(label: str) -> JsonObject | str:
    """Load a problem; return its variables, bounds and integer flags, or the error of loading it.

    One point of each kind of problem that compiles code is evaluated, so that no copy waits for a compiler or holds
    compiled code alone; no other problem is evaluated, as that may take long, but for the call by which a function is
    found to take one point or many.
    """
    with reading("problem", label):
        described = _load_problem(label)
    _settle()
    return described


def _load_problem(label: str) -> JsonObject | str:
    try:
        problem = _problem(label)
        described = {
            "variables": [str(name) for name in problem.variables],
            "lower": [float(value) for value in problem.lower],
            "upper": [float(value) for value in problem.upper],
            "integer": integer_flags(problem).tolist(),
            "initial": None if problem.initial_points is None else problem.initial_points.tolist(),
        }
    except BaseException as error:  # only its own trials fail
        return PROBLEM_FAILED + _failure(error)
    with contextlib.suppress(BaseException):  # the trials will report it
        kind = type(problem.unscored)
        warm_problem(problem, _study.budget.evaluations(problem.dimension), evaluated=kind not in _warm)
        _warm.add(kind)
    return described


def load_optimizer(label: str) -> None:
    """Load an optimizer, so that its modules are imported; its trials report errors."""
    with contextlib.suppress(BaseException), reading("optimizer", label):
        optimizer = _study.optimizer(label)
        observing.declare(_study.files(label))
        for name in optimizer.libraries:
            observing.note("libraries", str(name), "named")
    _settle()


def warm_up(optimizer: str, box: Box) -> bool:
    """Make and discard a short trial on a sphere in the ``box``, so that no trial waits for a compiler.

    Return whether one was made, which is once. The problem itself stays unseen, as what an optimizer keeps from here
    reaches all its trials.
    """
    with contextlib.suppress(BaseException), reading("optimizer", optimizer):  # the trial itself will report the error
        budget = _study.budget.evaluations(len(box.lower))
        is_warm = optimizer in _warm
        _warm.add(optimizer)
        if not is_warm:
            warm_optimizer(_study.optimizer(optimizer), box.lower, box.upper, box.integer, budget)
        scanner(budget, len(box.lower))
        if is_warm:
            return False
    _settle()
    return True


def make(trial: Trial, box: Box | None = None, end: int = -1) -> JsonObject:
    """Make one trial; return what :func:`bench.execution.answers.row` reads but the metrics, or why it failed.

    ``altered`` states whether the trial has left anything behind in this process.

    Args:
        trial: the trial.
        box: that of a problem that is kept apart, None for other trials.
        end: the file number of the socket at whose other end that problem is (:func:`serve`).
    """
    global _found
    effects = SideEffects()
    answer: JsonObject = {}
    journal = None
    try:
        optimizer = _study.optimizer(trial.optimizer)
        if box is None:
            with reading("problem", trial.problem):
                observing.declare(_study.files(trial.problem))
            journal = _journal(trial)
            problem: AbstractContextManager[Problem] = evaluated(
                _problem(trial.problem), *_study.rules.evaluation, journal
            )
        else:
            problem = closing(apart.RemoteProblem(end, box))
        beside = reading("problem", trial.problem) if box is None else nullcontext()
        with effects, beside, problem as minimized, reading("optimizer", trial.optimizer):
            observing.declare(_study.files(trial.optimizer))
            budget = _study.budget.evaluations(minimized.dimension)
            limit = _study.rules.time if box is None else None  # else the other process has it
            goal = _study.rules.goal(minimized) if box is None else -inf
            _found = search(minimized, optimizer, budget, trial.seed, end_if_stuck, limit, goal)
            answer = as_answer(_found)
        if journal is not None:
            answer |= {"replayed": journal.replayed, "dropped": journal.dropped}
            if not journal.slow:
                _fast.add(trial.problem)
        reason = _why_void(effects)
    except BaseException as error:  # a plug-in may raise anything; only its own trial fails
        reason = _failure(error)
    return ({"error": reason} if reason else answer | _inputs()) | {"altered": effects.any}


def _journal(trial: Trial) -> Journal | None:
    """Return the journal of a trial; None where it needs none, is to repeat another one, or can have none."""
    problem = _problem(trial.problem)
    if trial.again or trial.problem in _fast or problem.unscored.noisy or not (_output and Path(_output).is_dir()):
        return None
    entry = next(entry for entry in _study.problems if entry.label == trial.problem)
    key = trial.columns | {"budget": _study.budget.evaluations(problem.dimension), "variables": [*problem.variables]}
    about = {"name": entry.name, "options": entry.options}

    def read() -> Inputs:
        return named(observing.observed().get("problem", {}), [trial.problem])

    return Journal(Path(_output), key, about, read, _study.rules.evaluation_timeout, _study.rules.journal)


def serve(trial: Trial, end: int) -> JsonObject:
    """Keep the problem, the budget and the trace of a trial until its optimizer has ended.

    Return what :func:`bench.execution.answers.row` reads, and the metrics of the best point; or the error of the
    problem.
    """
    problem = _problem(trial.problem)
    with reading("problem", trial.problem), evaluated(problem, *_study.rules.evaluation) as minimized:
        observing.declare(_study.files(trial.problem))
        budget = _study.budget.evaluations(problem.dimension)
        stream, goal = streams(trial.seed)[0], _study.rules.goal(minimized)
        objective = scoring.objective(minimized, budget, stream, seconds=_study.rules.time, goal=goal)
        seconds = apart.serve(objective, end)
    try:
        kept = result(objective, trial.seed, Cost(seconds, 0.0, objective.objective_s, 0.0))
    except ProblemError as error:
        return {"error": _failure(error)}
    return as_answer(kept) | _confirmed(kept, problem) | _inputs()


def confirm(label: str) -> JsonObject:
    """Evaluate the best point of the trial that this process has made once more; return its metrics, or an error."""
    with reading("problem", label):
        return _confirmed(_found, _problem(label)) | _inputs()


def _confirmed(found: Result, problem: Problem) -> JsonObject:
    try:
        with closing(problem.unscored):
            reason = doubt(found, problem)
        if reason:
            return {"error": printable(reason, 4000)}
        try:
            return {"metrics": numbers(problem.describe(found.x.copy()))}
        except Exception as error:
            raise ProblemError(error) from error
    except ProblemError as error:
        return {"error": _failure(error)}


def as_answer(result: Result) -> JsonObject:
    """Return a result as JSON values, without its metrics: the columns of its row, bytes in base 64."""
    packed = {"x": result.x.astype("<f8").tobytes(), "trace": result.trace.packed()}
    texts = {name: base64.b64encode(content).decode() for name, content in packed.items()}
    return measured(result) | texts | {"log": result.log, "unasked": result.usage.unasked}


def _failure(error: BaseException) -> str:
    return printable(f"{located(error)}\n{''.join(traceback.format_exception(error, limit=-3))}", 4000)


def _inputs() -> JsonObject:
    """Return the digest of what this process has read, and all of that where it is new."""
    global _sent
    new, _sent = _sent != observing.digest(), observing.digest()
    return {"inputs": _sent} | ({"read": observing.observed()} if new else {})


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


def _settle() -> None:
    """Limit the libraries loaded by now to one thread, and set the global random states that every trial finds."""
    threadpool_limits(limits=1)  # the environment may not reach all of them
    reset_random()


@cache
def _problem(label: str) -> Problem:
    observing.declare(_study.files(label))
    return _study.problem(label)


_study: Study
_found: Result  # of the last trial
_output: str
_sent = ""  # the last digest of what was read
_fast: set[str] = set()  # labels of problems whose evaluations are worth no journal
_warm: set[type | str] = set()  # kinds of problems, and optimizers
