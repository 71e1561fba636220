"""How far other trials could move a ranking: by a plain, slow bootstrap, and in odd cases."""

import numpy as np
import pytest

from bench.analysis.cells import near_best, summarise
from bench.analysis.certainty import RESAMPLES, ranking_certainty, ranks_of_draws
from bench.analysis.pairwise import pairwise_tests
from bench.analysis.standings import standings

pytestmark = pytest.mark.filterwarnings("error")
LOW, FAR = [1.0, 2.0, 3.0, 4.0, 5.0], [11.0, 12.0, 13.0, 14.0, 15.0]


def test_the_ranks_of_a_resample_are_those_of_the_values_drawn(frame_of):
    rng = np.random.default_rng(0)
    values = [rng.normal(shift, 1, 7 + i).round(1) for i, shift in enumerate((0.0, 0.3, 0.2))]
    values[2][:2] = np.inf
    counts = [rng.multinomial(len(each), np.full(len(each), 1 / len(each)), size=5) for each in values]
    counts = [
        np.concatenate((np.ones((1, len(each)), dtype=int), own)) for each, own in zip(values, counts, strict=True)
    ]
    found = ranks_of_draws(values, [own.T.astype(np.float32) for own in counts])
    assert found.shape == (3, 6)
    for resample in range(6):
        drawn = {
            ("p", f"o{i}"): np.repeat(each, own[resample])
            for i, (each, own) in enumerate(zip(values, counts, strict=True))
        }
        cells = {key: [value if np.isfinite(value) else None for value in own] for key, own in drawn.items()}
        frame = frame_of(cells)
        ranks = standings(summarise(frame), pairwise_tests(frame))["rank"]
        assert found[:, resample].tolist() == ranks.tolist()


def test_a_clear_order_is_sure(frame_of):
    frame = frame_of({(problem, optimizer): own for problem in "pq" for optimizer, own in (("a", LOW), ("b", FAR))})
    found = ranking_certainty(frame).set_index("optimizer")
    assert found.loc["a", ["problems", "first_low", "first_high", "rank_low", "leads"]].tolist() == [2, 2, 2, 1.0, 1.0]
    assert found.loc["b", ["first_low", "first_high", "rank_high", "leads"]].tolist() == [0, 0, 2.0, 0.0]


def test_equal_optimizers_share_the_lead(frame_of):
    rng = np.random.default_rng(1)
    frame = frame_of({(f"p{i}", optimizer): rng.normal(size=20) for i in range(4) for optimizer in "ab"})
    found = ranking_certainty(frame)
    assert found["leads"].sum() == pytest.approx(1.0)
    assert (found["first_low"] < found["first_high"]).all()
    assert ranking_certainty(frame).equals(found)
    assert RESAMPLES[30] > 500


def test_an_interval_holds_the_observed_value(frame_of):
    cells = {("p", f"o{i:02d}"): [0.0] * 9 + [float(i % 3 == 0)] for i in range(20)}  # ties that resamples break
    frame = frame_of(cells)
    observed = standings(summarise(frame), pairwise_tests(frame)).set_index("optimizer")["rank"]
    found = ranking_certainty(frame).set_index("optimizer")
    assert (found["rank_low"] <= observed + 1e-9).all()
    assert (found["rank_high"] >= observed - 1e-9).all()


def test_nothing_to_draw(frame_of):
    single = frame_of({("p", "a"): [1.0], ("p", "b"): [2.0]})
    assert ranking_certainty(single)["first_low"].isna().all()
    gap = frame_of({("p", "a"): LOW, ("q", "b"): LOW})
    assert ranking_certainty(gap)["problems"].tolist() == [0, 0]
    assert ranking_certainty(frame_of({})).empty


def test_the_share_of_trials_near_the_best_known_value(frame_of):
    cells = {
        ("p", "a"): [1.0, 1.009, 2.0, None],
        ("p", "b"): [1.011, 3.0, 3.0, 3.0],
        ("q", "a"): [0.0],
        ("q", "b"): [1e-9],
    }
    assert near_best(frame_of(cells), {"p": 1.0, "q": 0.0}).to_dict() == {"a": 0.75, "b": 0.5}
    assert near_best(frame_of(cells), {"p": 1.005}).to_dict() == {"a": 0.75, "b": 0.5}  # a beaten optimum is none
    assert near_best(frame_of({("p", "a"): LOW, ("q", "b"): LOW}), {}).empty
    assert near_best(frame_of({("p", "a"): [None], ("p", "b"): [None]}), {}).to_dict() == {"a": 0.0, "b": 0.0}
