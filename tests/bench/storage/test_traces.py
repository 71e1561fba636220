"""Traces as bytes: what comes out is what went in, by key and in the store's order."""

import numpy as np

from bench import Trace
from bench.storage.reading import Traces

ONE = Trace(np.array([1, 5, 40]), np.array([3.0, 1.5, -2.0]))
NONE = Trace(np.empty(0, dtype=np.int64), np.empty(0))


def test_traces_are_found_by_key():
    other = Trace(np.array([2]), np.array([7.0]))
    packed = {("p", "a", 0): ONE.packed(), ("p", "a", 7): NONE.packed(), ("p", "b", 1): other.packed()}
    traces = Traces(packed)
    assert [*traces] == [("p", "a", 0), ("p", "a", 7), ("p", "b", 1)]
    assert len(traces) == 3
    assert traces["p", "a", 0].evaluations.tolist() == [1, 5, 40]
    assert traces["p", "a", 0].values.tolist() == [3.0, 1.5, -2.0]
    assert len(traces["p", "a", 7].values) == 0
    for missing in (("p", "a", 3), ("p", "a", 8), ("p", "c", 0), ("q", "a", 0)):
        assert traces.get(missing) is None
