"""Pairs on one problem: the adjustment against statsmodels, by hand on small samples, and as properties."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from statsmodels.stats.multitest import multipletests

from bench.analysis.cells import cells
from bench.analysis.direction import Effects, effects, inference, intervals, p_values
from bench.analysis.kolmogorov_smirnov import ks_tests
from bench.analysis.pairwise import COLUMNS, effect_size, holm, pairwise_tests

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INTERVALS = ["a12_low", "a12_high", "low", "high"]


def pair_of(frame_of, this, other, **options):
    pairs = pairwise_tests(frame_of({("p", "a"): this, ("p", "b"): other}), **options)
    assert len(pairs) == 1
    return pairs.iloc[0]


class TestAdjustment:
    @pytest.mark.parametrize("k", [1, 2, 10, 45])
    def test_holm(self, k):
        p = np.random.default_rng(k).beta(0.2, 1, k).round(2)  # rounded: with ties, zeros and ones
        np.testing.assert_allclose(holm(p), multipletests(p, method="holm")[1])

    @given(st.lists(st.floats(0, 1), max_size=20))
    def test_holm_raises_p_and_keeps_the_order(self, p):
        p = np.array(p)
        adjusted = holm(p)
        assert ((p <= adjusted) & (adjusted <= 1)).all()
        assert (np.diff(adjusted[np.argsort(p, kind="stable")]) >= 0).all()

    @pytest.mark.parametrize("seed", range(3))
    def test_is_over_all_pairs_of_a_problem(self, frame_of, seed):
        rng = np.random.default_rng(seed)
        shifts = dict(zip("abcd", 2 * rng.random(4), strict=True))
        pairs = pairwise_tests(
            frame_of({(each, name): rng.normal(shifts[name], 1, 20) for each in "pqr" for name in shifts})
        )
        assert len(pairs) == 18
        for _, own in pairs.groupby("problem", observed=True):
            p = inference(Effects(own["a12"].to_numpy(), own["ratio"].to_numpy(), 20.0), 0.05)[2]
            np.testing.assert_allclose(own["p_holm"], multipletests(p, method="holm")[1])
        assert (pairs["significant"] == (pairs["p_holm"] <= 0.05)).all()
        assert 0 < pairs["significant"].sum() < (pairs["p"] <= 0.05).sum()
        for pair in pairs.itertuples():
            favoured = pair.first if pair.a12 > 0.5 else pair.second
            assert pair.lower == (favoured if pair.significant else "")

    @pytest.mark.parametrize("seed", range(3))
    def test_another_optimizer_changes_nothing_but_the_claims(self, random_frame, seed):
        frame = random_frame(seed)
        pairs, fewer = pairwise_tests(frame), pairwise_tests(frame[frame["optimizer"] != "c"])
        common = pairs[(pairs["first"] != "c") & (pairs["second"] != "c")].reset_index(drop=True)
        claims = ["p_holm", "level", "low", "high", "significant", "lower"]
        pd.testing.assert_frame_equal(common.drop(columns=claims), fewer.drop(columns=claims), check_categorical=False)
        assert (common["p_holm"] >= fewer["p_holm"]).all()

    def test_pairs_without_a_row_are_tested_all_the_same(self, frame_of):
        rng = np.random.default_rng(5)
        shifts = {"a": 0.0, "b": 0.2, "c": 3.0, "d": 3.1}
        frame = frame_of({(each, name): rng.normal(shifts[name], 1, 20) for each in "pq" for name in shifts})
        keys = ["problem", "first", "second"]
        every, kept = pairwise_tests(frame), pairwise_tests(frame, kept=["b"]).set_index(keys)
        clearest = every.loc[every.groupby("problem", observed=True)["p_holm"].idxmin(), keys]
        of_b = every.loc[(every["first"] == "b") | (every["second"] == "b"), keys]
        assert {*kept.index} == {*pd.concat([of_b, clearest]).itertuples(index=False, name=None)}
        pd.testing.assert_frame_equal(kept, every.set_index(keys).loc[kept.index])


class TestColumns:
    @pytest.mark.parametrize("seed", range(2))
    def test_are_those_of_the_merged_cells(self, random_frame, seed):
        frame = random_frame(seed)
        found = cells(frame, merge=True)
        pairs = pairwise_tests(frame)
        assert tuple(pairs.columns) == COLUMNS
        for pair in pairs.to_dict("records"):
            both = [found[pair["problem"], pair[side]][np.newaxis] for side in ("first", "second")]
            effect = effects(*both)
            expected = {"a12": effect.a12, "ratio": effect.ratio, "p": p_values(effect), **ks_tests(*both)}
            ends = (*intervals(effect), *inference(effect, pair["level"])[:2])
            expected |= dict(zip(INTERVALS, ends, strict=True))
            assert {name: pair[name] for name in expected} == {name: own[0] for name, own in expected.items()}
            assert (pair["n_first"], pair["n_second"]) == tuple(own.shape[1] for own in both)


class TestByHand:
    def test_complete_separation(self, frame_of):
        pair = pair_of(frame_of, [6, 7, 8, 9, 10, 11.0], [0, 1, 2, 3, 4, 5.0])
        assert (pair.a12, pair.a12_low) == (0.0, pytest.approx(0))
        assert (pair.p, pair.p_holm, pair.lower, pair.significant) == (2**-5, 2**-5, "b", True)

    @pytest.mark.parametrize(
        ("value", "word"),
        [
            (0.5, "negligible"), (0.559, "negligible"), (0.56, "small"), (0.44, "small"), (0.63, "small"),
            (0.64, "medium"), (0.36, "medium"), (0.709, "medium"), (0.71, "large"), (0.29, "large"), (0.0, "large"),
            (1.0, "large"), (float("nan"), ""),
        ],
    )  # fmt: skip
    def test_effect_size(self, value, word):
        assert effect_size(value) == word


@pytest.fixture
def subjects(frame_of):
    """Return trials of one that is far lower than the two others."""
    rng = np.random.default_rng(1)
    shifts = {"a": 0.0, "b": 3.0, "c": 3.0}
    return frame_of({(p, name): rng.normal(shift, 1, 12) for p in "pqrs" for name, shift in shifts.items()})


def test_only_pairs_of_the_subject_are_hypotheses(subjects):
    every, own = pairwise_tests(subjects), pairwise_tests(subjects, subject="b")
    with_b = own[own["p_holm"].notna()]
    assert set(zip(with_b["first"], with_b["second"], strict=True)) == {("a", "b"), ("b", "c")}
    for _, rows in with_b.groupby("problem", observed=True):
        assert rows["p_holm"].to_numpy() == pytest.approx(holm(rows["p"].to_numpy()))
    assert own["p"].tolist() == every["p"].tolist()
    others = own[own["p_holm"].isna()]
    assert not others["significant"].any()
    assert set(others["lower"]) == {""}
