"""Verdicts on cells: exact laws, rounding, zeros, what cannot be judged, and the sentence on a table."""

import math
from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from bench.reproduce.table import PaperCell, PaperTable, Printed
from bench.reproduce.verdict import compare, compare_counts, compare_means, compare_order, judge, sentences

INTERVAL = "the 90% interval (t) of the difference of their means"


def number(value, unit=0.0):
    return Printed(value, unit, str(value))


def cell(function="1", optimizer="GWO", runs=30, **numbers) -> PaperCell:
    printed = {name: value if isinstance(value, Printed) else number(value) for name, value in numbers.items()}
    return PaperCell(1, "", function, optimizer, None, None, runs, "", printed, {})


def normal(mean, sd=1.0, n=30):
    """Return n values with this very mean and SD."""
    values = stats.norm.ppf((np.arange(n) + 0.5) / n)
    return mean + sd * (values - values.mean()) / values.std(ddof=1)


def judged(*pairs, **settings):
    table = PaperTable("t", tuple(each for each, _ in pairs), (), settings)
    return judge(table, {each: np.asarray(values, float) for each, values in pairs if len(values)}, {})


def verdicts(*pairs, **settings):
    return [each.verdict for each in judged(*pairs, **settings)]


def test_equal_means_of_many_runs_are_alike_and_far_ones_differ():
    same, far, near = cell(mean=10.0, sd=1.0), cell("2", mean=12.0, sd=1.0), cell("3", mean=10.65, sd=1.0)
    assert verdicts((same, normal(10)), (far, normal(10)), (near, normal(10))) == ["alike", "differs", "open"]


def test_the_test_of_means_is_student_s_with_the_larger_sd():
    p, _ = compare_means(number(11.0), number(2.0), 30, -math.inf, normal(10.0, 1.0, 20))
    assert p == pytest.approx(stats.ttest_ind_from_stats(11, 2, 30, 10, 2, 20).pvalue)


def test_no_p_is_below_that_of_samples_that_do_not_overlap():
    found = compare({"mean": number(1e6), "sd": number(1e-3)}, 3, np.zeros(3))
    assert found.p == pytest.approx(3 * 2 / 20)  # of three tests
    assert compare({"worst": number(0.0)}, 51, np.ones(51)).p > 0


def test_order_statistics_have_their_exact_law():
    """Of all ways to order 4 of theirs and 3 of ours, in how many are k of ours below the median, at least."""
    runs, n = 4, 3
    counts = []
    for places in combinations(range(runs + n), runs):
        ours = [place for place in range(runs + n) if place not in places]
        counts.append(sum(place < places[2] for place in ours))  # the upper of the two middle ones
    for below in range(n + 1):
        values = np.array([0.0] * below + [2.0] * (n - below))
        exact = np.mean([count >= below for count in counts])
        other = np.mean([count >= n - below for count in counts])  # by symmetry
        assert compare_order(number(1.0), runs, 2, 3, values) == pytest.approx(min(1.0, 2 * min(exact, other)))


@pytest.mark.parametrize("draw", [np.random.default_rng(1).exponential, np.random.default_rng(2).random])
def test_bounds_on_counts_hold_for_any_sample(draw):
    for _ in range(200):
        theirs, ours = draw(size=12), draw(size=9)
        p = compare_counts(number(theirs.mean()), number(theirs.std(ddof=1)), 12, 0.0, ours)
        ordered = np.sort(ours)
        below, above = (theirs < ordered[2]).sum(), (theirs > ordered[6]).sum()
        exact = min(stats.nhypergeom.sf(k - 1, 21, 12, 3) for k in (below, above))
        assert p >= min(1.0, 2 * exact) - 1e-12


def test_the_sentence_names_the_functions_that_differ():
    pairs = [(cell(f, o, mean=10.0, sd=1.0), normal(v)) for f, o, v in [
        ("1", "GWO", 10), ("1", "PSO", 10), ("12", "GWO", 12.5), ("12", "PSO", 7), ("3", "GWO", 10.7),
    ]]  # fmt: skip
    pairs.append((cell("4", "GWO", runs=1, mean=1.0, sd=0.0), normal(1)))
    assert sentences(judged(*pairs)) == [
        "2 of 5 cells differ, tested at 5% over the table: f12 (GWO 2.5 SD higher, PSO 3 SD lower)",
        f"2 do not differ, and {INTERVAL} lies within one SD; a failure rate of up to 10% can go unseen in 30 runs",
        "1 is open: no test shows a difference, and the interval is wider",
    ]


def test_no_more_than_one_in_twenty_tables_has_a_false_difference():
    """The worst design of ``validation/reproduce.py``: two values, as of two local optima."""
    rng = np.random.default_rng(5)
    theirs, ours = (rng.random((600 * 72, 30)) < 0.5 for _ in range(2))
    numbers = {"mean": number(theirs.mean(axis=1)), "sd": number(theirs.std(axis=1, ddof=1))}
    p = compare(numbers, 30, ours.astype(float), lowest=0.0).p
    assert (p.reshape(-1, 72) <= 0.05 / 72).any(axis=1).mean() < 0.05 + 2 * math.sqrt(0.05 * 0.95 / 600)


def test_a_cell_whose_numbers_exclude_each_other_is_not_judged():
    (impossible,) = judged((cell(mean=0.31, sd=1.9, best=0.07, runs=20), normal(0.5, 0.1)))
    assert impossible.verdict == "not judged"
    assert impossible.reason.startswith("it contradicts itself: an SD of 1.9 with the mean 0.31")
    assert verdicts((cell(mean=1.0, sd=9.0), normal(1.0)), values="error") == ["not judged"]
    assert verdicts((cell(mean=1.0, sd=9.0), normal(1.0))) == ["alike"]  # values may be below 0
    (known,) = judged((cell("cec2022-f04-d10", mean=801.0, sd=9.0), normal(801.0)))  # its optimum is 800
    assert "it contradicts itself" in known.reason
