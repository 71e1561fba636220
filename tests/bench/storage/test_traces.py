"""Traces as bytes: what comes out is what went in, by key and in the store's order."""

import numpy as np
import pytest

from bench import Trace
from bench.storage.traces import Traces

ONE = Trace(np.array([1, 5, 40]), np.array([3.0, 1.5, -2.0]))
NONE = Trace(np.empty(0, dtype=np.int64), np.empty(0))


def row(problem, optimizer, trial, trace):
    return {"problem": problem, "optimizer": optimizer, "trial": trial, "trace": trace}


def test_traces_are_found_by_key_and_failed_trials_have_none():
    other = Trace(np.array([2]), np.array([7.0]))
    rows = [
        row("p", "a", 0, ONE.packed()), row("p", "a", 3, None),
        row("p", "a", 7, NONE.packed()), row("p", "b", 1, other.packed()),
    ]  # fmt: skip
    traces = Traces.read(rows)
    assert [*traces] == [("p", "a", 0), ("p", "a", 7), ("p", "b", 1)]
    assert len(traces) == 3
    assert traces["p", "a", 0].evaluations.tolist() == [1, 5, 40]
    assert traces["p", "a", 0].values.tolist() == [3.0, 1.5, -2.0]
    assert len(traces["p", "a", 7].values) == 0
    for missing in (("p", "a", 3), ("p", "a", 8), ("p", "c", 0), ("q", "a", 0)):
        assert traces.get(missing) is None


@pytest.mark.parametrize("damaged", [ONE.packed()[:-8], "text", 5])
def test_a_damaged_trace_is_refused(damaged):
    with pytest.raises(ValueError, match="trial 4 is damaged"):
        Traces.read([row("p", "a", 4, damaged)])
    if isinstance(damaged, bytes):
        with pytest.raises(ValueError, match="40 bytes are no trace"):
            Trace.unpacked(damaged)
