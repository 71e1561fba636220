"""The competition's table: errors, signs and their error rate, and checkpoints."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from bench import Trace
from bench.analysis import pairwise_tests
from bench.analysis.competition import checkpoints, error_statistics, signs


def made(**cells):
    """Return a frame of problem p with such values by optimizer; None is a failed trial."""
    rows = [
        {
            "problem": "p",
            "optimizer": label,
            "trial": i,
            "fun": value,
            "nfev": 10,
            "status": "ok" if value else "failed",
        }
        for label, values in cells.items()
        for i, value in enumerate(values)
    ]
    return pd.DataFrame(rows)


def sign(mine, theirs):
    (row,) = signs(made(mine=mine, theirs=theirs), {}, "mine").to_dict("records")
    return row["sign"], row["p"]


class TestErrors:
    def test_they_are_counted_from_the_optimum_and_zero_from_1e_8_on(self):
        (row,) = error_statistics(made(a=[4.0, 6.0, 3.0 + 1e-9]), {"p": 3.0}).to_dict("records")
        assert (row["mean"], row["sd"], row["median"], row["best"], row["worst"]) == (
            pytest.approx(4 / 3), pytest.approx(np.std([1, 3, 0], ddof=1)), 1.0, 0.0, 3.0,
        )  # fmt: skip
        assert (row["known"], row["trials"], row["failed"]) == (True, 3, 0)

    def test_a_failed_trial_is_infinite_and_one_trial_has_no_deviation(self):
        (row,) = error_statistics(made(a=[4.0, None, 1.0]), {"p": 0.0}).to_dict("records")
        assert (row["mean"], row["median"], row["best"], row["worst"]) == (np.inf, 4.0, 1.0, np.inf)
        assert np.isnan(row["sd"])
        assert row["failed"] == 1
        assert error_statistics(made(a=[4.0]), {"p": 0.0})["sd"].isna().all()


class TestSigns:
    def test_they_are_seen_from_the_reference(self):
        low, high = list(np.arange(1.0, 21.0)), list(np.arange(11.0, 31.0))
        assert sign(low, high)[0] == "+"
        assert sign(high, low)[0] == "-"
        assert sign(low, low)[0] == "="

    def test_p_is_that_of_the_test_of_a12_whose_level_holds_where_spreads_differ(self):
        rng = np.random.default_rng(3)
        mine, theirs = rng.normal(5, 1, 40).tolist(), rng.normal(5.4, 1, 40).tolist()
        frame = made(a=mine, b=theirs)
        assert sign(mine, theirs)[1] == pytest.approx(pairwise_tests(frame)["p"].iloc[0])

    @pytest.mark.parametrize(
        ("pooled", "n"), [([1, *[2] * 13], 2), ([1] * 3 + [2] * 3, 3), ([1, 1, 2, 2, 3, 3, 4, 4], 3)]
    )
    def test_few_tied_trials_are_wrong_in_at_most_a_twentieth(self, pooled, n):
        """The normal approximation rejects in .07 to .14 of these arrangements, which are all equally probable."""
        chosen = list(combinations(range(len(pooled)), n))
        wrong, known = 0, {}
        for own in chosen:
            mine = [float(pooled[i]) for i in own]
            if (key := tuple(mine)) not in known:
                known[key] = sign(mine, [float(each) for i, each in enumerate(pooled) if i not in own])[0] != "="
            wrong += known[key]
        assert wrong / len(chosen) <= 0.05


class TestCheckpoints:
    def test_errors_are_those_at_the_checkpoint(self):
        frame = made(a=[4.0, 6.0, None])
        traces = {
            ("p", "a", 0): Trace(np.array([1, 5, 10]), np.array([9.0, 5.0, 4.0])),
            ("p", "a", 1): Trace(np.array([2, 9]), np.array([8.0, 6.0])),
        }
        table = checkpoints(frame, traces, {"p": 3.0}, {"p": (0.01, 0.5, 1.0)}, 10)
        assert table["evaluations"].tolist() == [1, 5, 10]
        assert table["best"].tolist() == [6.0, 2.0, 1.0]
        assert table["median"].tolist() == [np.inf, 5.0, 3.0]
        assert table["worst"].tolist() == [np.inf] * 3
        assert checkpoints(frame, traces, {}, {"p": (1.0,)}, 10).empty
        assert checkpoints(frame, traces, {"p": 3.0}, {}, 10).empty
