"""The rule of the clock: neither the time of day nor how long something takes decides a point or a value."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from types import BuiltinFunctionType

from bench.check.conformance.recording import expect_same
from bench.check.conformance.subject import AnySubject

_NAMES = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
_CLOCKS = [getattr(time, name + unit) for name in _NAMES for unit in ("", "_ns")]


def check_clock(subject: AnySubject) -> str:
    """A run is the same where every reading of a clock is an hour later than the one before."""
    plain, plugin = subject.run(), subject.fresh()
    with fast_clocks(plugin):
        fast = subject.run(instance=plugin)
    expect_same(
        plain.course(),
        fast.course(),
        "where its clocks go fast, it does otherwise",
        "use no clock: count evaluations by objective.remaining, and take no seed from the time",
    )
    return "a run is the same where the clocks go fast"


@contextmanager
def fast_clocks(plugin: object) -> Iterator[None]:
    """Make the clocks of Python gain an hour a reading, but for the harness and Python's own modules."""
    readings = count(1)

    def fast(clock: Callable[[], float]) -> Callable[[], float]:
        hour = 3600 * 10**9 if clock.__name__.endswith("_ns") else 3600
        return lambda: clock() + hour * next(readings)

    others = {clock: fast(clock) for clock in _CLOCKS}
    spared = {*sys.stdlib_module_names, "bench"} - {"time"}
    spaces = [vars(module) for name, module in list(sys.modules.items()) if name.partition(".")[0] not in spared]
    spaces += [getattr(method, "__globals__", {}) for base in type(plugin).__mro__ for method in vars(base).values()]
    changed = [
        (space, name, value)
        for space in spaces
        for name, value in list(space.items())
        if isinstance(value, BuiltinFunctionType) and value in others
    ]
    try:
        for space, name, clock in changed:
            space[name] = others[clock]
        yield
    finally:
        for space, name, clock in changed:
            space[name] = clock
