"""What is about to be done: blocks in random order, shards, and how long it may take."""

from collections import Counter

import pytest

from bench import BenchError, Study
from bench.execution.plan import Plan, Shard
from bench.storage.store import CellCounts


def study(trials=6, problems=3, optimizers=5):
    return Study.from_dict(
        {"name": "s", "trials": trials, "budget": 60, "seed": 1,
         "problems": [{"name": "sphere-2", "label": f"p{i}"} for i in range(problems)],
         "optimizers": [{"name": "scatter", "label": f"o{i}"} for i in range(optimizers)]}
    )  # fmt: skip


def test_trials_come_in_complete_blocks_each_in_an_order_by_chance():
    trials = list(study().plan())
    blocks = [trials[start : start + 15] for start in range(0, 90, 15)]
    cells = {(f"p{i}", f"o{j}") for i in range(3) for j in range(5)}
    for number, block in enumerate(blocks):
        assert {trial.number for trial in block} == {number}
        assert {trial.key[:2] for trial in block} == cells
    orders = {tuple(trial.key[:2] for trial in block) for block in blocks}
    assert len(orders) == 6
    first = Counter(trial.optimizer for trial in list(study(1000, 1).plan())[::5])
    assert all(140 < count < 260 for count in first.values())  # 200 expected, SD 13


def test_more_trials_leave_the_order_and_the_shards_as_they_are():
    assert list(study(6).plan())[:45] == list(study(3).plan())
    for number in (1, 2, 3, 4):
        short, long = (
            [trial.key for trial in Plan(study(trials), Shard(number, 4), set()).trials()] for trials in (4, 8)
        )
        assert long[: len(short)] == short


def test_shards_share_all_trials_evenly_and_mix_the_optimizers():
    every = [Plan(study(20), Shard(number, 5), set()) for number in range(1, 6)]
    keys = [[trial.key for trial in each.trials()] for each in every]
    assert sorted(key for each in keys for key in each) == sorted(trial.key for trial in study(20).plan())
    assert {len(each) for each in keys} == {60}
    for each in keys:  # five optimizers and five shards: taking every fifth of an unmixed plan would give one of each
        assert len({optimizer for _, optimizer, _ in each}) == 5


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b", "1/0", "-1/3", "1/3/5", "", "1.5/3"])
def test_what_is_no_shard(text):
    with pytest.raises(BenchError, match="as in 3/20"):
        Shard.parse(text)


def test_a_shard_reads_back():
    assert str(Shard.parse(" 3/20 ")) == "3/20"


@pytest.mark.parametrize("shard", [None, Shard(2, 4)])
def test_counts_are_those_of_the_trials(shard):
    finished = set()
    for trial in list(study().plan())[:40]:
        finished.add(trial.key)
    finished.add(("p0", "o0", 6))  # one of a run with more trials
    made = Plan(study(), shard, finished)
    expected: Counter = Counter()
    done: Counter = Counter()
    for trial in made.trials():
        expected[trial.key[:2]] += 1
        done[trial.key[:2]] += trial.key in finished
    assert made.counts() == {cell: (count, done[cell]) for cell, count in expected.items()}
    assert [trial.key for trial in made.missing()] == [t.key for t in made.trials() if t.key not in finished]


def test_the_time_goes_by_the_cell_then_the_optimizer_then_all():
    cells = [
        CellCounts("p0", "o0", {"ok": 2, "failed": 1}, 4.0),  # 2 s a trial
        CellCounts("p1", "o0", {"ok": 2}, 12.0),  # 6 s; o0 on p2 counts as the mean of 16 / 4
        CellCounts("p0", "o1", {"failed": 3}, 0.0),  # nothing to go by: the mean of all
    ]
    finished = set()
    for problem in ("p0", "p1"):
        for number in (0, 1):
            finished.add((problem, "o0", number))
    made = Plan(study(3, optimizers=2), None, finished, cells)
    assert made.seconds() == pytest.approx(1 * 2 + 1 * 6 + 3 * 4 + 9 * 4)
    assert Plan(study(3), None, set()).seconds() is None
    assert Plan(study(3), None, set(), [cells[2]]).seconds() is None
