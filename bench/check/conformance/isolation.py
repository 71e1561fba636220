"""Rules of isolation: a run depends on its seed and the objective's values alone, and leaves nothing behind."""

from __future__ import annotations

import gc
import multiprocessing
import os
import pickle
import random
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from itertools import count
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import IO

import cloudpickle
import numpy as np

from bench.check.conformance.recording import LOST, ViolationError, expect_same, explain_lost_process
from bench.check.conformance.single import PRINTED
from bench.check.conformance.subject import START_SECONDS, AnySubject, Subject, pack, unpack
from bench.check.problems import bowl
from bench.contract.typing import Floats
from bench.sandbox.messages import describe_error
from bench.sandbox.process import Process


def check_repetition(subject: Subject) -> str:
    """A seed repeats the run within a process; other seeds give other runs, or the method is deterministic."""
    remedy = (
        "draw from rng alone, start from objective.initial, and use no clock, no generator of your own and nothing "
        "that is kept in the module or the class"
    )
    run = subject.run()
    expect_same(run.course(), subject.run().course(), "two runs of one seed differ", remedy)
    others = [subject.run(seed=seed, global_seed=seed) for seed in (1, 2)]
    if all(other.course() == run.course() for other in others):
        return "deterministic: the seed repeats the run, and so does every other seed"
    if _own_states(subject, 0) & _own_states(subject, 1):
        raise ViolationError(
            "it draws from a generator of its own that has the same state for every seed, so that its moves from equal "
            "starts are equal for every seed",
            "draw from rng, or make the generator from a number drawn from rng",
        )
    return "a seed repeats its run, other seeds give others"


def _own_states(subject: Subject, seed: int) -> set[bytes]:
    """Return the states, seen now and then, of the generators that a run makes and draws from."""
    problem, seen, calls = bowl(), dict[int, list[bytes]](), count(1)
    evaluate, before = problem.evaluate, _generators()

    def watch(x: Floats, rng: np.random.Generator | None = None) -> Floats:
        if next(calls) in (2, 3, 8, 32, 128):  # to look takes longer than to evaluate
            for each in _generators():
                if not any(each is other for other in before):
                    state = each.bit_generator.state if isinstance(each, np.random.Generator) else each.__getstate__()
                    seen.setdefault(id(each), []).append(pickle.dumps(state))
        return evaluate(x, rng)

    problem.evaluate = watch  # type: ignore[method-assign]
    subject.run(problem, seed=seed)
    return {state for states in seen.values() if len(set(states)) > 1 for state in states}


def _generators() -> list[object]:
    kinds = (np.random.Generator, np.random.RandomState, random.Random)
    return [each for each in gc.get_objects() if issubclass(type(each), kinds)]


def check_processes(subject: AnySubject) -> str:
    """Trials in another process, in another order and with other hashes, give the same runs."""
    remedy = (
        "do not loop over a set or use hash() or id(): their order differs from process to process; use no process "
        "number, host name or environment variable, and keep nothing in the module or the class from run to run"
    )
    seeds = [0, 1, 2]
    here = [subject.run(seed=seed).course() for seed in seeds]
    with Process(hash_seed=1) as process:
        try:
            packed = subject.packed or pack(subject)
            there = process.call(courses, packed, seeds[::-1], seconds=START_SECONDS, printed=PRINTED)
        except LOST as error:
            finding, other_mend = explain_lost_process(error, process.note)
            raise ViolationError(f"in another process, {finding}", other_mend) from error
    for first, second in zip(here, reversed(there), strict=True):
        expect_same(first, second, "a seed gives another run in another process, after other runs", remedy)
    return f"{len(seeds)} trials gave the same runs in two processes, in two orders"


def courses(packed: bytes, seeds: list[int]) -> list[list[int]]:
    """Return the courses of runs with these seeds."""
    subject = unpack(packed)
    return [subject.run(seed=seed).course() for seed in seeds]


def check_state(subject: AnySubject) -> str:
    """Nothing is kept in the instance from run to run."""
    used = subject.fresh()
    before = subject.parameters(used)
    subject.run(instance=used)
    after = subject.parameters(used)
    remedy = "keep what changes during a run in local variables of its methods, not in self"
    changed = [name for name in before if after.get(name) != before[name]]
    if changed:
        raise ViolationError(
            f"a run changes its {changed[0]!r} from {before[changed[0]]} to {after[changed[0]]}", remedy
        )
    new, again = (subject.run(instance=instance, seed=1) for instance in (None, used))
    expect_same(new.course(), again.course(), "a second run of one instance differs from that of a new one", remedy)
    return "a second run of one instance equals that of a new one"


def check_pickling(subject: AnySubject) -> str:
    """Workers get their optimizer by pickle."""
    original = subject.fresh()
    copy = pickle.loads(cloudpickle.dumps(original))
    remedy = "keep the whole configuration in the fields, as plain values"
    if type(copy).__qualname__ != type(original).__qualname__:
        raise ViolationError(f"its pickled copy is a {type(copy).__name__}, not a {type(original).__name__}", remedy)
    if subject.parameters(copy) != subject.parameters(original) and copy != original:
        raise ViolationError("its pickled copy has other parameters", remedy)
    run, other = (subject.run(instance=instance) for instance in (original, copy))
    expect_same(run.course(), other.course(), "its pickled copy runs differently", remedy)
    return "a pickled copy has the same parameters and gives the same run"


def check_global_states(subject: AnySubject) -> str:
    """Neither Python's nor numpy's global random state is used or changed."""
    remedy = (
        "draw from rng alone: no random.random(), no np.random.rand() and no seeding of them; a library that needs "
        "them gets a seed drawn from rng, and the states are restored afterwards"
    )
    run = subject.run()
    if run.touched:
        raise ViolationError(f"a run changes the global random state of {' and '.join(run.touched)}", remedy)
    other = subject.run(global_seed=1)
    expect_same(run.course(), other.course(), "a run depends on the global random states", remedy)
    return "the global random states of Python and numpy are neither used nor changed"


def check_anonymity(subject: Subject) -> str:
    """A problem's name, variables and known optimum change nothing."""
    run, other = subject.run(), subject.run(bowl(name="other", variables=("a", "b", "c"), optimum=-1.0))
    finding = "its run depends on the problem's name, variables or known optimum"
    remedy = "use nothing of the problem but the objective's values and bounds"
    expect_same(run.course(), other.course(), finding, remedy)
    return "the problem's name, variables and known optimum change nothing"


def check_contract(subject: Subject) -> str:
    """The optimizer uses only what the objective offers."""
    run = subject.run()
    if run.reached:
        raise ViolationError(
            f"it reads or sets {', '.join(sorted(run.reached))} of the objective",
            "use what the contract offers: objective(x), .lower, .upper, .integer, .dimension, .budget, .remaining, "
            ".repair(x), .initial(n) and .stop(reason)",
        )
    return "it uses nothing of the objective but what the contract offers"


def check_silence(subject: AnySubject) -> str:
    """A run prints nothing: the harness shows progress, and a study makes thousands of runs."""
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as file:
        with warnings.catch_warnings(record=True) as warned, _output_to(file):
            warnings.simplefilter("default")
            subject.run()
        file.seek(0)
        text = file.read()
    if text.strip():
        first = next(line for line in text.splitlines() if line.strip()).strip()
        raise ViolationError(
            f"a run printed {len(text)} characters, such as {first[:60]!r}",
            "print and log nothing; switch off the messages of the libraries that you call",
        )
    if warned:
        return f"nothing printed; warned: {describe_error(warned[0].message)}"  # type: ignore[arg-type]
    return "nothing printed"


def check_leftovers(subject: AnySubject) -> str:
    """A run leaves no files, threads or processes behind; what a library starts once is not counted."""
    instances = [subject.fresh() for _ in range(2)]  # before the folder changes: a name may be a relative path
    running = [_running()]
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for instance in instances:
            subject.run(instance=instance)
            running.append(_running(running[-1]))
        files = sorted(path.name for path in Path(folder).iterdir())
    if files:
        raise ViolationError(
            f"a run leaves {len(files)} file{'s' * (len(files) > 1)} in the working folder, such as {files[0]!r}",
            "write no files; switch off the logs of the libraries that you call",
        )
    for kind, before, after in zip(("thread", "process"), *running[1:], strict=True):
        if after > before:
            raise ViolationError(
                f"every run leaves a {kind} running",
                f"end every {kind} in a finally of what starts it",
            )
    return "no files, threads or processes are left"


def _running(before: tuple[float, float] = (inf, inf)) -> tuple[int, int]:
    """Return the numbers of threads and processes; those about to end, if more run than before, get time to do so."""
    until = monotonic() + 0.5
    while True:
        now = threading.active_count(), len(multiprocessing.active_children())
        if (now[0] <= before[0] and now[1] <= before[1]) or monotonic() >= until:
            return now
        sleep(0.02)


@contextmanager
def _output_to(file: IO[str]) -> Iterator[None]:
    """Write to a file what goes to the standard streams, also from outside Python."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [(descriptor, os.dup(descriptor)) for descriptor in (1, 2)]
    for descriptor, _ in saved:
        os.dup2(file.fileno(), descriptor)
    try:
        with redirect_stdout(file), redirect_stderr(file):
            yield
    finally:
        for descriptor, before in saved:
            os.dup2(before, descriptor)
            os.close(before)
        file.flush()
