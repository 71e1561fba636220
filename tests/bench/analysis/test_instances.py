import numpy as np
import pandas as pd
import pytest

from bench.analysis import pool_instances
from bench.contract.objective import Trace

PROBLEMS = ["f-d2-i1", "f-d2-i2", "other"]
FEATURES = {"f-d2-i1": {"instance": 1}, "f-d2-i2": {"instance": 2}, "other": {}}
OPTIMA = {"f-d2-i1": 10.0, "f-d2-i2": -5.0, "other": 1.0}


def frame_of(**funs):
    rows = [
        {"problem": name.replace("_", "-"), "optimizer": "o", "trial": trial, "fun": fun, "status": "ok"}
        for name, values in funs.items()
        for trial, fun in enumerate(values)
    ]
    return pd.DataFrame(rows)


FRAME = frame_of(f_d2_i1=[10.5, 12.0], f_d2_i2=[-5.0 + 1e-9, 3.0], other=[2.0, 3.0])


def trace(*values):
    return Trace(np.arange(1, len(values) + 1), np.array(values))


TRACES = {
    ("f-d2-i1", "o", 0): trace(20.0, 10.5),
    ("f-d2-i2", "o", 0): trace(0.0, -5.0 + 2e-9, -5.0 + 1e-9),
    ("other", "o", 0): trace(4.0, 2.0),
}


def test_instances_are_trials_of_their_function_and_values_are_precisions():
    pooled = pool_instances(FRAME, TRACES, PROBLEMS, FEATURES, OPTIMA)
    assert pooled.members == {"f-d2": ["f-d2-i1", "f-d2-i2"], "other": ["other"]}
    assert pooled.functions == ["f-d2"]
    assert [*pooled.frame["problem"]] == ["f-d2"] * 4 + ["other"] * 2
    assert [*pooled.frame["trial"]] == [0, 1, 2, 3, 0, 1]
    assert [*pooled.frame["fun"]] == [0.5, 2.0, 0.0, 8.0, 2.0, 3.0]
    assert [*pooled.frame["instance"][:4]] == [1, 1, 2, 2]


def test_traces_end_at_the_last_target_and_keep_falling():
    traces = pool_instances(FRAME, TRACES, PROBLEMS, FEATURES, OPTIMA).traces
    assert traces["f-d2", "o", 0].values.tolist() == [10.0, 0.5]
    assert traces["f-d2", "o", 2].values.tolist() == [5.0, 0.0]
    assert traces["f-d2", "o", 2].evaluations.tolist() == [1, 2]
    assert traces["other", "o", 0] is TRACES["other", "o", 0]


@pytest.mark.parametrize(
    ("frame", "features", "optima"),
    [
        (FRAME, FEATURES, {"other": 1.0}),  # no optimum is known
        (FRAME, {name: {} for name in PROBLEMS}, OPTIMA),  # no instances
        (FRAME, FEATURES | {"f-d2-i1": {"instance": 3}}, OPTIMA),  # a label that does not end with its instance
        (frame_of(f_d2_i1=[9.0], f_d2_i2=[0.0], other=[2.0]), FEATURES, OPTIMA),  # a beaten optimum is none
    ],
)
def test_what_cannot_be_pooled_stays_as_it_is(frame, features, optima):
    pooled = pool_instances(frame, TRACES, PROBLEMS, features, optima)
    assert pooled.members == {name: [name] for name in PROBLEMS}
    assert pooled.frame is frame
    assert pooled.traces is TRACES
