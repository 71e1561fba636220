"""The rule of a problem that is kept apart: with it in another process, the run is the same."""

from __future__ import annotations

import socket
from contextlib import suppress

from threadpoolctl import threadpool_limits

from bench.check.conformance.recording import (
    LOST,
    RecordedRun,
    ViolationError,
    expect_same,
    explain_lost_process,
    seeded_global_states,
)
from bench.check.conformance.subject import START_SECONDS, Subject, ordinary_budget, pack, unpack
from bench.check.problems import bowl
from bench.execution import apart
from bench.execution.safe_runs import PRINTED
from bench.objective import BudgetExhausted, Objective, integer_flags
from bench.sandbox.process import Process
from bench.seeds import streams


def check_apart(subject: Subject) -> str:
    """Problem, budget and trace in another process change nothing: nothing is evaluated past the objective."""
    remedy = "get values from objective(x) alone, and nothing else of the problem or of the objective's inside"
    budget = ordinary_budget(subject.fresh())
    here = subject.run().course()
    packed = subject.packed or pack(subject)
    with Process(hash_seed=0) as keeper, Process(hash_seed=0) as process:
        one, other = socket.socketpair()
        with one, other:
            keeper.start(keep, budget, subject.seed, files=[one.fileno()])
            process.start(run_apart, packed, budget, files=[other.fileno()])
        try:
            process.finish(seconds=START_SECONDS, printed=PRINTED)
        except LOST as error:
            finding, other_mend = explain_lost_process(error, process.note)
            raise ViolationError(f"with the problem in another process, {finding}", other_mend) from error
        process.close()
        there = keeper.finish(seconds=START_SECONDS)
    expect_same(here, there, "with problem and budget in another process, its run is another", remedy)
    return f"the problem and the budget of {budget} evaluations in another process change nothing"


def keep(budget: int, seed: int, end: int) -> list[int]:
    """Keep the ordinary problem for a run in another process; return the course of the run."""
    problem = bowl()
    apart.serve(Objective(problem, budget, streams(seed)[0]), end)
    return RecordedRun(points=problem.points).course()


def run_apart(packed: bytes, budget: int, end: int) -> None:
    """Run the optimizer on the problem at the other end of the socket."""
    subject, problem_here = unpack(packed), bowl()
    problem = apart.RemoteProblem(end, problem_here.lower, problem_here.upper, integer_flags(problem_here))
    start_stream, search_stream = streams(subject.seed)
    objective = Objective(problem, budget, start_stream)
    with threadpool_limits(limits=1), seeded_global_states(0), suppress(BudgetExhausted):
        subject.fresh().minimize(objective, search_stream)
    problem.close()
