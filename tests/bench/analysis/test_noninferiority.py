"""The gate: its interval and its test, at the margin, on every problem, and for small, tied and failed samples."""

import numpy as np
import pytest
from scipy.stats import norm

from bench import BenchError
from bench.analysis.noninferiority import compare_samples


def compared(samples, **settings):
    return compare_samples({problem: [both] for problem, both in samples.items()}, **settings)


def normal(seed, problems=6, n=30, shift=0.0):
    rng = np.random.default_rng(seed)
    return {str(i): (rng.standard_normal(n), rng.standard_normal(n) + shift) for i in range(problems)}


def test_tests_and_intervals_agree_and_one_problem_is_its_own_mean():
    ((this, other),) = normal(1, problems=1, n=30, shift=1.5).values()
    found = compared({"p": (this, other)})
    (row,) = found.problems.to_dict("records")
    assert found.a12 == np.mean(np.less.outer(this, other))
    assert [row[each] for each in ("a12", "low", "high", "p")] == pytest.approx(
        [found.a12, found.low, found.high, found.p]
    )
    at_low = compared({"p": (this, other)}, margin=found.low - 0.5)  # where the interval begins, p is its level
    assert at_low.p == pytest.approx(0.025)


def test_the_mean_is_as_sure_as_independent_problems_make_it():
    samples = normal(8, problems=4, n=40)
    found = compared(samples)
    widths = (found.problems["high"] - found.problems["low"]).to_numpy()
    assert found.high - found.low == pytest.approx(np.sqrt((widths**2).sum()) / 4, rel=0.05)
    assert found.a12 == pytest.approx(found.problems["a12"].mean())


def test_a_version_that_is_clearly_worse_is_named_with_its_problems():
    samples = normal(2, problems=15) | {"bad": tuple(np.array([[0.0], [1.0]]) + np.arange(30) / 100)}
    found = compared(samples)
    assert found.outcome == "worse"
    assert not found.worse_overall
    assert list(found.problems.loc[found.problems["worse"], "problem"]) == ["bad"]
    assert compared(normal(2, shift=0.8)).worse_overall


def one_worse(seed, a12=0.7, problems=12, n=60):
    """Return samples of equal versions on all problems but the last, where A12 is this large."""
    rng = np.random.default_rng(seed)
    samples = {str(i): tuple(rng.standard_normal((2, n))) for i in range(problems)}
    old, new = samples[str(problems - 1)]
    samples[str(problems - 1)] = old, new + 2**0.5 * norm.ppf(a12)
    return samples


def test_a_loss_on_one_problem_that_the_mean_hides_is_open_there_and_no_pass_on_every_problem():
    passed = []
    for seed in range(10):
        found = compared(one_worse(seed))
        if found.passed:  # on average, which is true: the mean of A12 is 0.517
            passed.append(seed)
            assert "11" in set(found.problems.loc[~found.problems["not_worse"], "problem"])
        assert compared(one_worse(seed), every=True).passed is False
    assert passed


def test_every_problem_is_shown_to_be_not_worse_with_enough_trials_and_a_false_pass_is_rare():
    assert compared(one_worse(1, 0.5, problems=6, n=150), margin=0.2, every=True).passed
    passes = sum(
        compared(one_worse(seed, a12=0.7, problems=2, n=100), margin=0.2, every=True).passed for seed in range(100)
    )
    assert passes <= 8  # of 100 at a level of 2.5 %: a binomial exceeds this in 0.2 % of cases


def test_false_alarms_are_rare_at_the_margin_itself():
    rng = np.random.default_rng(7)
    alarms = 0
    for _ in range(100):
        samples = {}
        for number in range(6):
            old, new, other = rng.standard_normal((3, 15))
            samples[str(number)] = old, np.where(rng.random(15) < 0.3, np.maximum(new, other), new)  # A12 = 0.55
        alarms += compared(samples).outcome == "worse"
    assert alarms <= 11  # of 100 at a level of 5 %: a binomial exceeds this in less than 0.5 % of cases


def test_a_level_that_is_none_is_refused():
    with pytest.raises(BenchError, match=r"alpha is 1\.0"):
        compared(normal(1), alpha=1.0)
