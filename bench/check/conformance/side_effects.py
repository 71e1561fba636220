"""Rules of side effects: a run uses only what the objective offers, prints nothing and leaves nothing behind."""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from math import inf
from pathlib import Path
from time import monotonic, sleep
from typing import IO

from bench.check.conformance.recording import ViolationError
from bench.check.conformance.subject import Subject
from bench.sandbox.messages import describe_error


def check_contract(subject: Subject) -> str:
    """The optimizer uses only what the objective offers."""
    run = subject.run()
    if run.reached:
        raise ViolationError(
            f"it reads or sets {', '.join(sorted(run.reached))} of the objective",
            "use what the contract offers: objective(x), .lower, .upper, .dimension, .budget, .remaining, .repair(x), "
            ".initial(n) and .stop(reason)",
        )
    return "it uses nothing of the objective but what the contract offers"


def check_silence(subject: Subject) -> str:
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


def check_leftovers(subject: Subject) -> str:
    """A run leaves no files, threads or processes behind; what a library starts once is not counted."""
    optimizers = [subject.fresh() for _ in range(2)]  # before the folder changes: a name may be a relative path
    running = [_running()]
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for optimizer in optimizers:
            subject.run(optimizer=optimizer)
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
                f"every run leaves a {kind} running", f"end every {kind} before minimize ends, in a finally"
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
