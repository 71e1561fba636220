"""The expected time with several workers: by hand, and where the order of optimizers changes."""

from math import ceil

import numpy as np
import pandas as pd
import pytest

from bench.analysis import expected_running_time, parallel_times
from bench.analysis.parallel import parallel_ranks

INF = float("inf")


def trials(cells):
    """Build hitting times and trials from {optimizer: (times, spent, nfev / calls, own seconds of an evaluation)}."""
    hits, rows = [], []
    for optimizer, (times, spent, batch, own) in cells.items():
        for number, time in enumerate(times):
            key = {"problem": "p", "optimizer": optimizer, "trial": number}
            hits.append(key | {"tau": 0.1, "target": 0.1, "evaluations": float(time), "spent": float(spent)})
            about = {
                "nfev": spent,
                "calls": ceil(spent / batch),
                "largest_call": ceil(batch),
                "wall_s": 1.0 + own * spent,
                "objective_s": 1.0,
            }
            rows.append(key | {"status": "ok"} | about)
    return pd.DataFrame(hits), pd.DataFrame(rows)


def time_of(cells, workers, seconds):
    table = parallel_times(*trials(cells), [workers], [seconds])
    return table.set_index("optimizer")["time"].to_dict()


@pytest.mark.parametrize(
    ("evaluation", "workers", "turns"),
    [
        (1, 1, 1),
        (30, 1, 30),
        (31, 1, 31),
        (1, 8, 1),
        (8, 8, 1),
        (9, 8, 2),
        (30, 8, 4),
        (31, 8, 5),
        (60, 8, 8),
        (31, 64, 2),
    ],
)
def test_calls_take_whole_turns_of_the_workers(evaluation, workers, turns):
    assert time_of({"a": ([evaluation], 90, 30, 0.0)}, workers, 2.0) == {"a": 2.0 * turns}


def test_the_optimizer_s_own_time_is_added_and_no_worker_shortens_it():
    cell = {"a": ([60], 90, 30, 0.5)}
    assert time_of(cell, 1, 2.0)["a"] == pytest.approx(60 * 2 + 60 * 0.5)
    assert time_of(cell, 64, 2.0)["a"] == pytest.approx(2 * 2 + 60 * 0.5)


def test_one_worker_is_the_expected_running_time():
    hits, frame = trials({"a": ([10, 20, INF], 100, 10, 0.0), "b": ([INF], 100, 1, 0.0)})
    times = parallel_times(hits, frame, [1], [1.0])
    expected = expected_running_time(hits).set_index("optimizer")["ert"]
    assert times.set_index("optimizer")["time"].to_dict() == expected.to_dict() == {"a": 65.0, "b": INF}


def test_a_mean_batch_between_two_whole_numbers_lies_between_them():
    hits, frame = trials({"a": ([85], 85, 8.5, 0.0)})
    frame["largest_call"] = 20
    assert parallel_times(hits, frame, [8], [1.0])["time"].tolist() == [9 * 1.5 + 2]


def test_a_last_call_that_the_budget_cut_does_not_count():
    assert time_of({"a": ([106], 180, 25, 0.0)}, 8, 1.0)["a"] == 4 * 4 + 1


def test_a_failed_trial_counts_with_the_batch_of_its_cell():
    hits, frame = trials({"a": ([10, INF], 100, 10, 0.0)})
    frame.loc[1, ["status", "nfev", "calls", "largest_call", "wall_s", "objective_s"]] = ["failed", *[None] * 5]
    assert parallel_times(hits, frame, [10], [1.0])["time"].tolist() == [1 + 10]


def test_cells_whose_calls_are_not_known_have_no_row():
    hits, frame = trials({"a": ([10], 100, 10, 0.0), "b": ([10], 100, 10, 0.0)})
    frame.loc[frame["optimizer"] == "b", "calls"] = np.nan
    assert set(parallel_times(hits, frame)["optimizer"]) == {"a"}
    assert parallel_times(hits, frame.drop(columns="calls")).empty
    assert parallel_ranks(parallel_times(hits, frame.drop(columns="calls"))).empty


def test_the_order_changes_where_one_asks_for_many_points_at_once():
    cells = {"one by one": ([40], 100, 1, 0.0), "batches": ([60], 90, 30, 0.0), "none": ([INF], 90, 30, 0.0)}
    ranks = parallel_ranks(parallel_times(*trials(cells), [1, 8], [1.0])).set_index(["workers", "optimizer"])["rank"]
    assert ranks[1].to_dict() == {"one by one": 1.0, "batches": 2.0, "none": 3.0}
    assert ranks[8].to_dict() == {"one by one": 2.0, "batches": 1.0, "none": 3.0}
