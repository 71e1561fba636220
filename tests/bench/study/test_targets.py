"""The targets that a study may name."""

import math

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from bench.study.targets import KINDS, Found, Targets, fractions


@pytest.mark.parametrize(
    ("given", "held"),
    [
        *((kind, kind) for kind in KINDS),
        (" precisions ", "precisions"),
        ([1e-3, 10, 1e-3], [10.0, 1e-3]),
        ("1e-3, 10", [10.0, 1e-3]),
        (["1%", "5%"], ["5%", "1%"]),
        ("1 %,05%", ["5%", "1%"]),
        ("0.1%", ["0.1%"]),
    ],
)
def test_what_is_allowed_is_held_from_easy_to_hard(given, held):
    targets = Targets.read(given)
    assert targets.plain == held
    assert Targets.read(held) == targets == held


@pytest.mark.parametrize(
    "given",
    ["", "precision", "1e-3, 5%", "-1", "0", "nan", "1e999", "0%", "-5%", [], [0], [True], [1, "5%"], [[1]], [math.inf],
     3, None, {}, ["5"], [1.0 + i for i in range(1001)]],
)  # fmt: skip
def test_anything_else_is_refused_in_one_sentence(given):
    with pytest.raises(BenchError, match=r"^the targets must be 'precisions', .* or 'tolerance', ") as error:
        Targets.read(given, "the targets")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("given", "level", "words", "shown"),
    [
        ("relative", 0.01, "tau = 0.01", "0.01"),
        ("precisions", 1e-8, "precision = 1e-08", "1e-08"),
        ("runlength", 1 / 1.2, "the target for 1.2 d evaluations", "1.2"),
        ("5%", 0.05, "5% of the optimum", "0.05"),
        ("tolerance", 0.5, "0.5 times the tolerance", "0.5"),
        ("quantiles", 0.25, "quantile = 0.25", "0.25"),
    ],
)
def test_a_level_in_words_and_in_a_table(given, level, words, shown):
    targets = Targets.read(given)
    assert (targets.at(level), targets.level_text(level)) == (words, shown)
    assert targets.in_unit(pd.DataFrame({"tau": [level]}))["tau"].tolist() == pytest.approx([float(shown)])


def test_the_ladder_falls_by_ten_steps_a_decade():
    assert (len(fractions(known=False)), len(fractions(known=True))) == (31, 81)
    assert fractions(known=True)[[0, 10, 30, 80]].tolist() == [1.0, 0.1, 0.001, 1e-8]
    np.testing.assert_allclose(np.diff(np.log10(fractions(known=True))), -0.1)


@pytest.mark.parametrize("given", ["relative", "precisions", "quantiles", [10, 1e-3], ["5%"]])
def test_the_levels_of_tables_are_those_of_targets_which_begin_at_the_reference(given):
    targets = Targets.read(given)
    levels, values = targets.rungs(Found(reference=2.0, known=True, first=12.0, finals=np.array([2.0, 12.0])))
    assert np.isclose([*targets.tabled, *targets.levels, targets.level], levels[:, np.newaxis]).any(axis=0).all()
    assert (values >= 2.0).all()
