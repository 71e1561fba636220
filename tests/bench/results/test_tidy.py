import json

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from bench.results.tidy import COLUMNS, Tidy
from bench.storage.reading import READ
from bench.storage.rows import NAMES
from bench.trial.columns import packed

PROBLEMS, OPTIMIZERS = {"a": 0, "b": 1, "c": 2}, {"o": 0, "p": 1}


def rows(count=7):
    """Yield stored rows of problems with other variables and metrics, of which some failed."""
    for cell, (problem, optimizer) in enumerate(((p, o) for o in ("p", "o") for p in ("c", "a", "b")), start=1):
        for trial in range(count):
            value = cell + trial / 7
            names = {"a": ["u", "v"], "b": ["v", "u"], "c": ["w"]}[problem]
            row = {
                "cell": cell, "problem": problem, "optimizer": optimizer, "trial": trial, "environment": 1 + trial % 2,
                "seed": 2**62 + trial, "status": "ok", "fun": value, "nfev": 10, "wall_s": 0.5, "cpu_s": 0.25,
                "objective_s": 0.125, "stop": "budget", "outside_box": 0, "error": None,
                "x": {name: value + place for place, name in enumerate(names)}, "metrics": {f"of {problem}": value},
            }  # fmt: skip
            lost = dict.fromkeys(
                ("fun", "nfev", "wall_s", "cpu_s", "objective_s", "stop", "outside_box", "x", "metrics")
            )
            yield row | lost | {"status": "failed", "error": f"E{trial}"} if trial % 3 == 1 else row


def tidy(rows, size):
    """Return the frame of rows that are added some at a time, as a store yields them."""
    rows, frame, names = list(rows), Tidy(), {}
    cells = {row["cell"]: ("s", row["problem"], row["optimizer"]) for row in rows}
    read = []
    for row in rows:
        kept = packed({name: value for name, value in row.items() if value is not None})
        lists = tuple(kept.get(each) for each in NAMES)
        if None not in lists:
            kept["names"] = names.setdefault(lists, len(names) + 1)
        texts = {name: value.encode() for name, value in kept.items() if isinstance(value, str)}
        read.append(tuple((kept | texts).get(name) for name in READ))
    for start in range(0, len(read), size):
        frame.add(read[start : start + size], cells, {number: each for each, number in names.items()}, {1: 1, 2: 2})
    return frame.frame(PROBLEMS, OPTIMIZERS)


def plain(rows):
    """Return the frame made row by row, by pandas alone."""
    every = sorted(rows, key=lambda row: (PROBLEMS[row["problem"]], row["optimizer"], row["trial"]))
    records = [
        {"study": "s"} | {name: row.get(name) for name in COLUMNS[1:]}
        | {f"x_{name}": value for name, value in (row["x"] or {}).items()} | (row["metrics"] or {})
        for row in every
    ]  # fmt: skip
    return pd.DataFrame(records)


@pytest.mark.parametrize("size", [1, 5, 7, 40, 1000])
def test_the_frame_is_that_made_row_by_row(size):
    found, expected = tidy(rows(), size), plain(rows())
    assert list(found) == [*COLUMNS, "x_u", "x_v", "x_w", "of a", "of b", "of c"]
    pd.testing.assert_frame_equal(found, expected[list(found)], check_exact=True)
    assert (found["seed"] == expected["seed"]).all()  # beyond 2^53


def test_without_failures_whole_numbers_stay_whole():
    frame = tidy((row for row in rows() if row["status"] == "ok"), 4)
    assert [str(frame[name].dtype) for name in ("trial", "seed", "nfev", "outside_box")] == ["int64"] * 4


def test_where_every_trial_failed_there_are_no_values():
    frame = tidy((row for row in rows() if row["status"] != "ok"), 4)
    assert list(frame) == [*COLUMNS]
    assert frame[["fun", "nfev", "stop"]].isna().all(axis=None)


def test_a_problem_may_have_other_metrics_in_some_trials():
    kinds = [{"part": 0.5, "whole": np.nan}, {"whole": 2.0, "more": 1.0}, {}]
    changed = [row | {"metrics": kinds[row["trial"] // 2 % 3]} for row in rows() if row["status"] == "ok"]
    for size in (1, 3, 100):
        found = tidy(changed, size)
        assert {*found} == {*COLUMNS, "x_u", "x_v", "x_w", "part", "whole", "more"}
        pd.testing.assert_frame_equal(found, plain(changed)[list(found)], check_exact=True)


def test_a_trial_without_a_seed_leaves_every_digit_of_the_others():
    some = [row | {"seed": None} if row["trial"] == 2 else row for row in rows()]
    seeds = tidy(some, 4)["seed"]
    assert seeds.isna().sum() == 6
    assert {*seeds.dropna()} == {2**62 + trial for trial in (0, 1, 3, 4, 5, 6)}


def test_no_trials_give_an_empty_frame():
    assert list(tidy([], 1)) == [*COLUMNS]


@pytest.mark.parametrize(("name", "value"), [("x", b"1234567"), ("metrics", b""), ("x", None)])
def test_numbers_that_do_not_fit_their_names_are_named_by_their_problem(name, value):
    frame, names = Tidy(), {1: (json.dumps(["u", "v"]), json.dumps(["m"]))}
    row = dict.fromkeys(READ) | {"cell": 1, "trial": 0, "names": 1, "x": bytes(16), "metrics": bytes(8), name: value}
    with pytest.raises(BenchError, match=f"the store is damaged: '{name}' of a trial of o on a cannot be read"):
        frame.add([tuple(row.values())], {1: ("s", "a", "o")}, names, {})


def test_the_order_of_columns_is_that_of_the_study_not_of_the_commits():
    first, second = (tidy(each, 4) for each in (rows(), list(rows())[::-1]))
    assert list(first)[len(COLUMNS) :] == ["x_u", "x_v", "x_w", "of a", "of b", "of c"]
    pd.testing.assert_frame_equal(first, second)
