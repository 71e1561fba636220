"""Whether runs keep the budget and the box, meet any dimension and any values, and repeat with their seed."""

from __future__ import annotations

import dataclasses
import pickle

import cloudpickle
import numpy as np

from bench.check import landscapes
from bench.check.fault import LET_IT_PASS, FaultError, UnmadeError, describe, expect_same, expect_same_course
from bench.check.probe import Run
from bench.check.subject import Subject, ordinary_budget, pack, parameters, unpack
from bench.problem import FunctionProblem
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError, Process, Pulse, SilentError

CLIP = (
    "clip to objective.lower and objective.upper, or call objective.repair(x), as the last step before objective(x): "
    "mapping points back from a unit cube can leave the box by rounding"
)
GUARD = "guard divisions by ranges or sums of values: they can be zero or infinite"

START = 120.0  # seconds without a sign of life while a process imports, compiles and makes its first run


def check_run(subject: Subject) -> str:
    """One ordinary run comes to its end."""
    try:
        subject.fresh()
    except Exception as error:  # which the check of the parameters has met too
        raise UnmadeError from error
    run = subject.run(landscapes.bowl())
    if not len(run.points):
        raise FaultError("it returned without a single evaluation", "ask objective(x) for the values of points")
    return f"{len(run.points)} evaluations of a function of three variables, ended by: {run.stop}"


def check_budget(subject: Subject) -> str:
    """All of any budget is spent, or the stop is declared; and nothing is asked for after the end."""
    agents = subject.fresh().minimum_budget
    budgets = sorted({1, max(1, agents - 1), agents, agents + 1, 3 * agents + 3, 1000})
    stops = set()
    for budget in budgets:
        stops.add(_within_budget(subject.run(landscapes.bowl(), budget=budget), budget))
    declared = sorted(stops - {"budget"})
    kept = f"kept budgets of {', '.join(map(str, budgets))}"
    return f"{kept}; stopped early, saying: {'; '.join(declared)}" if declared else f"{kept} to the evaluation"


def _within_budget(run: Run, budget: int, where: str = "") -> str:
    """Return why the run ended; raises FaultError unless it was by the budget or by a declared stop."""
    if run.asked_after:
        raise FaultError(
            f"it asked {run.asked_after} more time{'s' * (run.asked_after > 1)} after the budget of {budget} was "
            f"spent{where}",
            LET_IT_PASS,
        )
    if not len(run.points):
        raise FaultError(
            f"it returned without a single evaluation of a budget of {budget}{where}",
            "evaluate also where the budget is below one generation: loop until the budget ends the run",
        )
    if run.stop == "undeclared":
        raise FaultError(
            f"it returned after {len(run.points)} of {budget} evaluations{where} and did not say why",
            "loop until the budget ends the run, or draw the last batch from objective.remaining; say that you stop "
            'by a criterion of your own with objective.stop("reason")',
        )
    return run.stop


def check_repetition(subject: Subject) -> str:
    """A seed repeats the run within a process; other seeds give other runs, or the method is deterministic."""
    run = subject.run(landscapes.bowl())
    expect_same(run, subject.run(landscapes.bowl()), "two runs of one seed differ",
          "draw from rng alone, start from objective.initial, and use no clock, no generator of your own and nothing "
          "that is kept in the module or the class")  # fmt: skip
    others = [subject.run(landscapes.bowl(), seed=seed, global_seed=seed) for seed in (1, 2)]
    if all(other.course() == run.course() for other in others):
        return "deterministic: the seed repeats the run, and so does every other seed"
    if not any(each.drew for each in (run, *others)):
        return "a seed repeats its run, other seeds give others; nothing is drawn from rng"
    return "a seed repeats its run, other seeds give others"


def check_processes(subject: Subject) -> str:
    """Trials in another process, in another order and with other hashes, give the same runs."""
    mend = "do not loop over a set or use hash() or id(): their order differs from process to process; use no process "
    mend += "number, host name or environment variable, and keep nothing in the module or the class from run to run"
    seeds = [0, 1, 2]
    here = [subject.run(landscapes.bowl(), seed=seed).course() for seed in seeds]
    with Process(hash_seed=1, nested=subject.expendable) as process:
        try:
            there = process.call(
                courses, subject.packed or pack(subject), seeds[::-1], patience=START, on_pulse=subject.pulse
            )
        except (SilentError, DiedError) as error:
            finding, other_mend = describe(error, process)
            raise FaultError(f"in another process, {finding}", other_mend) from error
    for mine, other in zip(here, reversed(there), strict=True):
        expect_same_course(mine, other, "a seed gives another run in another process, after other runs", mend)
    return f"{len(seeds)} trials gave the same runs in two processes, in two orders"


def courses(packed: bytes, seeds: list[int], pulse: Pulse | None = None) -> list[list[int]]:
    """Return the courses of runs with these seeds."""
    subject = dataclasses.replace(unpack(packed), pulse=pulse)
    return [subject.run(landscapes.bowl(), seed=seed).course() for seed in seeds]


def check_state(subject: Subject) -> str:
    """Nothing is kept in the instance from run to run."""
    used = subject.fresh()
    before = parameters(used)
    subject.run(landscapes.bowl(), optimizer=used)
    after = parameters(used)
    mend = "keep what changes during a run in local variables of minimize, not in self"
    changed = [name for name in before if after.get(name) != before[name]]
    if changed:
        raise FaultError(
            f"a run changes its parameter {changed[0]!r} from {before[changed[0]]} to {after[changed[0]]}", mend
        )
    new, again = (subject.run(landscapes.bowl(), optimizer=each, seed=1) for each in (None, used))
    expect_same(new, again, "a second run of one instance is not that of a new one", mend)
    return "a second run of one instance is that of a new one"


def check_pickling(subject: Subject) -> str:
    """Workers get their optimizer by pickle."""
    optimizer = subject.fresh()
    copy = pickle.loads(cloudpickle.dumps(optimizer))
    mend = "keep all that makes the optimizer in its fields, and these plain values"
    if type(copy).__qualname__ != type(optimizer).__qualname__:
        raise FaultError(f"its pickled copy is a {type(copy).__name__}, not a {type(optimizer).__name__}", mend)
    if parameters(copy) != parameters(optimizer) and copy != optimizer:
        raise FaultError("its pickled copy has other parameters", mend)
    run, other = (subject.run(landscapes.bowl(), optimizer=each) for each in (optimizer, copy))
    expect_same(run, other, "its pickled copy runs differently", mend)
    return "a pickled copy has the same parameters and gives the same run"


def check_global_states(subject: Subject) -> str:
    """Neither Python's nor numpy's global random state is used or changed."""
    mend = "draw from rng alone: no random.random(), no np.random.rand() and no seeding of them; a library that needs "
    mend += "them gets a seed drawn from rng, and the states are put back afterwards"
    run = subject.run(landscapes.bowl())
    if run.touched:
        raise FaultError(f"a run changes the global random state of {' and '.join(run.touched)}", mend)
    other = subject.run(landscapes.bowl(), global_seed=1)
    expect_same(run, other, "a run depends on the global random states", mend)
    return "the global random states of Python and numpy are neither used nor changed"


def check_box(subject: Subject) -> str:
    """No evaluation is wasted outside the box, be it uneven, narrow and with the optimum in a corner."""
    problem, optimizer = landscapes.corner(), subject.fresh()
    run = subject.run(problem, optimizer=optimizer, budget=4 * ordinary_budget(optimizer))
    if run.outside:
        inside = ((run.points >= problem.lower) & (run.points <= problem.upper)).all(axis=1)
        raise FaultError(
            f"{run.outside} of {len(run.points)} points lie outside the box, such as "
            f"{run.points[~inside][0].tolist()} in the box from {problem.lower.tolist()} to {problem.upper.tolist()}; "
            f"each costs an evaluation and is worth +inf",
            GUARD if not np.isfinite(run.points).all() else CLIP,
        )
    return f"{len(run.points)} points, none outside a narrow and uneven box far from the origin"


def check_repair(subject: Subject) -> str:
    """A problem may repair more than the box; whether the optimizer has it do so is its own choice, and is told."""
    problem = landscapes.half()
    run = subject.run(problem)
    share = float((problem.repair(run.points) != run.points).any(axis=1).mean())
    if not share:
        return "all points are feasible by the problem's own repair"
    return f"{share:.0%} of the points are infeasible by the problem's own repair (it may use objective.repair(x))"


def check_dimensions(subject: Subject) -> str:
    """Problems of any dimension are run."""
    dimensions = (1, 2, 7, 50)
    for dimension in dimensions:
        _each(subject, landscapes.bowl(dimension), f" in {dimension} dimension{'s' * (dimension > 1)}")
    return f"runs in {', '.join(map(str, dimensions))} dimensions"


def check_values(subject: Subject) -> str:
    """Any values are met: equal, infinite, huge, tiny and negative ones; NaN reaches an optimizer as +inf."""
    for name, problem in landscapes.odd().items():
        run = _each(subject, problem, f" with {name}")
        bad = int((~np.isfinite(run.points)).any(axis=1).sum())
        if bad:
            raise FaultError(
                f"it asked for {bad} points that are not finite with {name}",
                GUARD,
            )
    return f"runs with {', '.join(landscapes.odd())}"


def _each(subject: Subject, problem: FunctionProblem, where: str) -> Run:
    """Return a run that kept its budget; raises FaultError, saying where, for one that did not or that raised."""
    optimizer = subject.fresh()
    try:
        run = subject.run(problem, optimizer=optimizer)
    except (Exception, SystemExit) as error:
        raise FaultError(f"it raised {describe_error(error)}{where}", "") from error
    if run.stop == "undeclared" and subject.run(landscapes.bowl()).stop != run.stop:  # one that is usual is told once
        _within_budget(dataclasses.replace(run, asked_after=0), ordinary_budget(optimizer), where)
    return run
