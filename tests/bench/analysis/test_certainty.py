"""How far other trials could move a ranking, by a plain, slow bootstrap, and what fewer trials would have given."""

import numpy as np
import pytest

from bench.analysis.cells import near_best, summarise
from bench.analysis.certainty import COLUMNS, rank_stability, ranking_certainty, ranks_of_strata
from bench.analysis.direction import wins
from bench.analysis.pairwise import pairwise_tests
from bench.analysis.standings import against_rivals, mean_ranks, ranks, standings

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
LOW, FAR = [1.0, 2.0, 3.0, 4.0, 5.0], [11.0, 12.0, 13.0, 14.0, 15.0]


def test_the_ranks_of_a_resample_are_those_of_the_values_drawn(frame_of):
    rng = np.random.default_rng(0)
    values = [rng.normal(shift, 1, 7 + i).round(1) for i, shift in enumerate((0.0, 0.3, 0.2))]
    values[2][:2] = np.inf
    counts = [rng.multinomial(len(each), np.full(len(each), 1 / len(each)), size=5) for each in values]
    counts = [
        np.concatenate((np.ones((1, len(each)), dtype=int), own)) for each, own in zip(values, counts, strict=True)
    ]
    found = ranks_of_strata([(values, [own.T.astype(np.float32) for own in counts])])
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


def test_a_clear_order_is_sure_and_the_seed_repeats(frame_of):
    frame = frame_of({(problem, optimizer): own for problem in "pq" for optimizer, own in (("a", LOW), ("b", FAR))})
    found = ranking_certainty(frame)
    assert found.to_numpy().tolist() == [["a", 2, 1.0, 1.0], ["b", 2, 2.0, 2.0]]
    assert tuple(found.columns) == COLUMNS
    mixed = frame_of({("p", "a"): LOW, ("p", "b"): [each + 0.5 for each in LOW]})
    assert ranking_certainty(mixed).equals(ranking_certainty(mixed))


@pytest.mark.slow
def test_the_interval_covers_the_mean_rank_that_such_trials_give_on_average(frame_of):
    rng = np.random.default_rng(1)
    shifts, problems, n, studies = np.array([0.0, 0.2, 0.6, 1.5]), 3, 8, 60
    values = rng.normal(shifts[:, np.newaxis], 1, (4_000, len(shifts), n))
    chances = np.full((4_000, len(shifts), len(shifts)), 0.5)
    for one, other in np.argwhere(~np.eye(len(shifts), dtype=bool)):
        chances[:, one, other] = wins(values[:, one], values[:, other]).mean(axis=(1, 2))
    beaten, chance = against_rivals(chances, axis=2)
    expected = ranks(beaten.T, chance.T).mean(axis=1)
    held = []
    for _ in range(studies):
        frame = frame_of(
            {(f"p{i}", f"o{j}"): rng.normal(shift, 1, n) for i in range(problems) for j, shift in enumerate(shifts)}
        )
        found = ranking_certainty(frame)
        held.append(((found["rank_low"] <= expected) & (found["rank_high"] >= expected)).to_numpy())
    assert np.mean(held) >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / studies)


def test_an_interval_holds_the_observed_value(frame_of):
    cells = {("p", f"o{i:02d}"): [0.0] * 9 + [float(i % 3 == 0)] for i in range(20)}  # ties that resamples break
    frame = frame_of(cells)
    observed = standings(summarise(frame), pairwise_tests(frame)).set_index("optimizer")["rank"]
    found = ranking_certainty(frame).set_index("optimizer")
    assert (found["rank_low"] <= observed + 1e-9).all()
    assert (found["rank_high"] >= observed - 1e-9).all()


def test_nothing_to_draw(frame_of):
    single = frame_of({("p", "a"): [1.0], ("p", "b"): [2.0]})
    assert ranking_certainty(single)[["rank_low", "rank_high"]].isna().all(axis=None)
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


def test_the_ranks_are_the_standings_of_the_first_trials(random_frame):
    frame = random_frame(5, problems=3, trials=14, failing=0.1)
    found = rank_stability(frame)
    assert found["trials"].min() == 3
    assert found["trials"].max() == 14
    for trials, own in found.groupby("trials"):
        early = frame[frame["trial"] < trials]
        expected = mean_ranks(standings(summarise(early), pairwise_tests(early)))
        assert own.set_index("optimizer")["rank"].to_dict() == pytest.approx(expected.to_dict())


def test_bands_hold_the_curve_and_end_in_a_point(random_frame):
    found = rank_stability(random_frame(6, trials=20))
    assert (found["low"] <= found["rank"]).all()
    assert (found["rank"] <= found["high"]).all()
    last = found[found["trials"] == 20]
    assert (last["low"] == last["high"]).all()
    assert (found[found["trials"] == 3]["high"] > found[found["trials"] == 3]["low"]).any()


def test_a_smaller_cell_enters_with_all_it_has(frame_of):
    rng = np.random.default_rng(1)
    values = rng.random(12)
    found = rank_stability(frame_of({("p", "a"): values, ("p", "b"): 9 + rng.random(4)}))
    assert found["trials"].max() == 12
    assert found.groupby("optimizer")["rank"].unique().map(list).to_dict() == {"a": [1.0], "b": [2.0]}


def test_no_curve_of_ranks_without_more_trials_than_the_first(frame_of):
    assert rank_stability(frame_of({("p", "a"): [1.0] * 9})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0] * 3, ("p", "b"): [2.0] * 3})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0] * 9, ("q", "b"): [2.0] * 9})).empty
    assert rank_stability(frame_of({("p", "a"): [1.0]}).head(0)).empty


def test_instances_take_turns(frame_of):
    # pooled: the first five trials are of instance 1, on which a is better; over both it is a tie
    a, b = [0.0] * 5 + [9.0] * 5, [1.0] * 5 + [8.0] * 5
    frame = frame_of({("p", "a"): a, ("p", "b"): b})
    frame = frame.assign(instance=np.where(frame["trial"] < 5, 1, 2))
    found = rank_stability(frame).set_index(["optimizer", "trials"])["rank"]
    assert found["a", 4] == found["b", 4] == 1.5
