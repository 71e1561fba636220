"""Which implementations are called different."""

import numpy as np
import pytest

from bench.atlas.compare import centre_bias, compare, findings
from bench.atlas.runs import MEASURES, PROBLEMS, Surveyed
from bench.atlas.table import Implementation
from bench.errors import BenchError
from tests.bench.atlas.made import surveyed


def test_a_planted_difference_is_found_and_copies_are_not():
    found = compare([surveyed("a", seed=1), surveyed("b", seed=2), surveyed("c", seed=3, shift=5.0)])
    verdicts = {(row["first"], row["second"]): row["different"] for row in found.pairs.to_dict("records")}
    assert verdicts == {("a", "b"): False, ("a", "c"): True, ("b", "c"): True}
    assert found.groups == {"m a": "A", "m b": "A", "m c": "B"}
    row = found.pairs.iloc[1]
    assert [row[each] for each in MEASURES] == [len(PROBLEMS)] * len(MEASURES)
    assert row["orders"] == pytest.approx(5.0, abs=1.0)  # a is lower
    assert row["distance"] > row["floor"]


def test_p_is_adjusted_over_all_tests_of_all_methods():
    pair = [surveyed("a", seed=1), surveyed("b", seed=2)]
    others = [surveyed(str(number), method="n", seed=number) for number in range(4)]
    alone, beside = compare(pair), compare([*pair, *others])
    assert len(beside.tests) == (1 + 6) * len(PROBLEMS) * len(MEASURES)
    least = alone.tests["p"].min()
    assert alone.tests["p_holm"].min() == pytest.approx(min(1, least * len(alone.tests)))
    assert beside.tests["p_holm"].min() == pytest.approx(min(1, beside.tests["p"].min() * len(beside.tests)))


def test_no_pair_is_made_of_two_methods():
    found = compare([surveyed("a", seed=1), surveyed("a", method="n", seed=2, shift=5.0)])
    assert found.pairs.empty
    assert found.tests.empty
    assert found.groups == {"m a": "A", "n a": "A"}


def test_equal_values_are_not_different():
    same = {problem: np.ones((12, len(MEASURES))) for problem in PROBLEMS}
    one, other = (Surveyed(Implementation("m", each, each), "", same, surveyed(each).behaviours) for each in "ab")
    found = compare([one, other])
    assert not found.pairs["different"].any()
    assert (found.tests["p"] == 1).all()


def test_few_trials_can_show_nothing():
    found = compare([surveyed("a", trials=3), surveyed("b", trials=3, seed=1, shift=9.0)])
    assert not found.enough
    assert not found.pairs["different"].any()
    assert found.similarity is None


def test_failed_implementations_are_left_out():
    found = compare([surveyed("a"), Surveyed(Implementation("m", "b", "b"), failed="it cannot"), surveyed("c", seed=1)])
    assert len(found.pairs) == 1
    with pytest.raises(BenchError, match="no implementation could be run; b: it cannot"):
        compare([Surveyed(Implementation("m", "b", "b"), failed="it cannot")])


def test_a_lower_error_at_the_centre_and_points_on_the_bounds_are_biases():
    own = surveyed("a", clamped=0.5)
    own.measures["sphere moved"][:] *= 1e30
    assert centre_bias(own.measures) > 1e5
    [centre, bounds] = findings(own)
    assert centre.startswith("biased to the centre (errors are ")
    assert bounds == "biased to the bounds (50% of the best points' coordinates lie on them)"
    assert findings(surveyed("b")) == []


@pytest.mark.slow
def test_copies_are_called_different_in_few_atlases():
    wrong = [
        compare([surveyed(name, trials=10, seed=7 * number + at, decimals=1) for at, name in enumerate("abc")])
        .pairs["different"].any()
        for number in range(60)
    ]  # fmt: skip
    assert np.mean(wrong) <= 0.1
