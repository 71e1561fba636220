import json

import pandas as pd
import pytest

from bench import BenchError
from bench.storage.blocks import NUMBERS, pack
from bench.storage.digests import JSON, TEXTS
from bench.storage.tidy import COLUMNS, tidy

PROBLEMS, OPTIMIZERS = ["a", "b", "c"], ["o", "p"]


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
                "x": {name: value + place for place, name in enumerate(names)}, "figures": {f"of {problem}": value},
            }  # fmt: skip
            lost = dict.fromkeys(
                ("fun", "nfev", "wall_s", "cpu_s", "objective_s", "stop", "outside_box", "x", "figures")
            )
            yield row | lost | {"status": "failed", "error": f"E{trial}"} if trial % 3 == 1 else row


def blocks(rows, size):
    """Yield the rows in blocks of a size."""
    rows = list(rows)
    labels = {row["cell"]: (row["problem"], row["optimizer"]) for row in rows}
    for start in range(0, len(rows), size):
        yield "s", pack(columns(rows[start : start + size]), labels)


def columns(rows):
    """Return the rows as a store yields them, column by column."""
    found = {name: [row[name] for row in rows] for name in ("cell", *NUMBERS)}
    found |= {name: [None if row[name] is None else row[name].encode() for row in rows] for name in TEXTS}
    return found | {
        name: [None if row[name] is None else json.dumps(row[name]).encode() for row in rows] for name in JSON
    }


def plain(rows):
    """Return the frame made row by row, by pandas alone."""
    every = sorted(rows, key=lambda row: (PROBLEMS.index(row["problem"]), row["optimizer"], row["trial"]))
    records = [
        {"study": "s"} | {name: row[name] for name in COLUMNS[1:]}
        | {f"x_{name}": value for name, value in (row["x"] or {}).items()} | (row["figures"] or {})
        for row in every
    ]  # fmt: skip
    return pd.DataFrame(records)


@pytest.mark.parametrize("size", [1, 5, 7, 40, 1000])
@pytest.mark.parametrize("known", [0, 42])
def test_the_frame_is_that_made_row_by_row(size, known):
    found, expected = tidy(blocks(rows(), size), known, PROBLEMS, OPTIMIZERS), plain(rows())
    assert list(found) == [*COLUMNS, "x_u", "x_v", "x_w", "of a", "of b", "of c"]
    pd.testing.assert_frame_equal(found, expected[list(found)], check_exact=True)
    assert (found["seed"] == expected["seed"]).all()  # beyond 2^53


def test_without_failures_whole_numbers_stay_whole():
    frame = tidy(blocks((row for row in rows() if row["status"] == "ok"), 4), 30, PROBLEMS, OPTIMIZERS)
    assert [str(frame[name].dtype) for name in ("trial", "seed", "nfev", "outside_box")] == ["int64"] * 4


def test_where_every_trial_failed_there_are_no_values():
    frame = tidy(blocks((row for row in rows() if row["status"] != "ok"), 4), 30, PROBLEMS, OPTIMIZERS)
    assert list(frame) == [*COLUMNS]
    assert frame[["fun", "nfev", "stop"]].isna().all(axis=None)


def test_metrics_of_any_kind_are_kept():
    kinds = [{"count": 1, "flag": True, "word": "one", "part": 0.5}, {"count": 2, "flag": False, "word": "two"}]
    changed = [row | {"figures": kinds[row["trial"] % 2]} for row in rows() if row["status"] == "ok"]
    for size in (1, 3, 100):
        found = tidy(blocks(changed, size), 40, PROBLEMS, OPTIMIZERS)
        pd.testing.assert_frame_equal(found, plain(changed)[list(found)], check_exact=True)


def test_no_trials_give_an_empty_frame():
    assert list(tidy([], 0, PROBLEMS, OPTIMIZERS)) == [*COLUMNS]


@pytest.mark.parametrize("name", JSON)
def test_a_damaged_text_is_named_by_its_trial(name):
    damaged = columns(list(rows()))
    damaged[name][14] = b'{"u": '
    labels = {row["cell"]: (row["problem"], row["optimizer"]) for row in rows()}
    with pytest.raises(BenchError, match=rf"the store is damaged: '{name}' of trial 0 of p on b cannot be read"):
        pack(damaged, labels)


def test_the_order_of_columns_is_that_of_the_study_not_of_the_commits():
    first, second = (tidy(blocks(each, 4), 42, PROBLEMS, OPTIMIZERS) for each in (rows(), list(rows())[::-1]))
    assert list(first)[len(COLUMNS) :] == ["x_u", "x_v", "x_w", "of a", "of b", "of c"]
    pd.testing.assert_frame_equal(first, second)
