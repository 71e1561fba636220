"""Training and test problems that have nothing in common, and the study that a tuning writes."""

import pytest

from bench import BenchError
from bench.study.budget import Budget
from bench.study.tuned import Tuned
from bench.tuning.study import load, split, tuned, untuned
from bench.tuning.tune import Best, TuningSetup

SETTING = TuningSetup("aocc", 2, 1, Budget.read("20 * d"), 7, ("sphere-3",), {"agents": 6})
WEAK = "multimodal, weak global structure"


def test_patterns_are_resolved_and_the_order_is_random_but_the_same():
    train, test = split(["bbob-f0[1-9]-d2-i1"], ["bbob-f0[12]-d2-i2"], None, 1)
    assert sorted(train) == [f"bbob-f0{number}-d2-i1" for number in range(1, 10)]
    assert test == ["bbob-f01-d2-i2", "bbob-f02-d2-i2"]
    assert train == split(["bbob-f0[1-9]-d2-i1"], ["bbob-f01-d2-i2"], None, 1)[0]
    assert train != split(["bbob-f0[1-9]-d2-i1"], ["bbob-f01-d2-i2"], None, 2)[0] != sorted(train)


def test_a_group_that_is_left_out_is_what_the_test_runs_on():
    train, test = split(["bbob-f*-d2-i1"], (), WEAK, 0)
    assert test == [f"bbob-f{number}-d2-i1" for number in range(20, 25)]
    assert len(train) == 19
    assert not set(train) & set(test)


@pytest.mark.parametrize(
    ("train", "test", "group", "said"),
    [
        (["sphere-2", "sphere-3"], ["sphere-3"], None, "'sphere-3' is a training and a test problem"),
        (["sphere-2"], [], None, "at least one test problem"),
        (["bbob-f20-d2-i1"], [], WEAK, "at least one training problem"),
        (["bbob-f0[12]-d2-i1"], ["sphere-2"], "separable", "give either --test or --leave-out"),
        (["bbob-f0[12]-d2-i1"], [], "separabel", "no training problem is of the group 'separabel'; did you mean 'sep"),
        (["sphere-2"], [], "separable", "no training problem is of the group 'separable'; there are none"),
        (["nothing"], ["sphere-2"], None, "unknown problem 'nothing'"),
    ],
)
def test_what_is_no_split_costs_one_sentence(train, test, group, said):
    with pytest.raises(BenchError) as caught:
        split(train, test, group, 0)
    assert said in str(caught.value)


def test_two_names_of_the_same_data_are_no_split(tmp_path):
    import numpy as np

    t = np.arange(0, 5, 0.01)
    for name in ("a.csv", "b.csv"):
        lines = [f"{time:.3f},{np.sin(time):.6f}" for time in t]
        (tmp_path / name).write_text("time_s,speed_rps\n" + "\n".join(lines), encoding="utf-8")
    both = [f"recording:{tmp_path / name}" for name in ("a.csv", "b.csv")]
    with pytest.raises(BenchError, match="have the same data; train and test on different data"):
        split(both[:1], both[1:], None, 0)


def test_a_problem_without_a_known_optimum_cannot_be_trained_on():
    with pytest.raises(BenchError, match=r"the optimum of 'cec2011-.*' is unknown, so no regret can be measured"):
        load([unknown()])


def unknown():
    from bench.plugins import registry

    family = registry.load("problems", "cec2011")
    return next(name for name in family.names() if family.load(name).optimum is None)


def test_the_study_has_defaults_and_tuned_parameters_and_the_record():
    def record(tuned):
        return Tuned("scatter", "scatter", tuned, {}, {}, [0.5], [1], 0, 9, 0.1)

    found = [Best(record("scatter-tuned"), {"agents": 9})]
    study = tuned("mine", ["sphere-2"], found, SETTING, left_out="", method="optuna")
    assert [(entry.label, entry.options) for entry in study.optimizers] == [
        ("scatter", {"agents": 6}),
        ("scatter-tuned", {"agents": 9}),
    ]
    assert study.tuning.train == ["sphere-3"]
    assert study.tuning.is_apart(["sphere-2"])
    assert "not tuned on" not in study.title  # the record says so, and only where it is there and unchanged
    assert (study.budget, study.seed) == ("20 * d", 7)
    same = tuned("mine", ["sphere-2"], [Best(record("scatter"), {})], SETTING, left_out="", method="optuna")
    assert len(same.optimizers) == 1


def test_what_the_test_could_not_run_is_refused_before_anything_is_tuned():
    assert untuned("mine", ["sphere-2"], ["scatter"], SETTING).tuning is None
    with pytest.raises(BenchError, match="must be up to 100 letters"):
        untuned("no name!", ["sphere-2"], ["scatter"], SETTING)
