"""Matched controls: which a study lacks, and a folder that is extended by them."""

import pandas as pd
import pytest

from bench import BenchError, Results, Study, run
from bench.execution.job import Task
from bench.execution.runner import plan
from bench.execution.supervisor import check
from bench.storage.folder import Folder
from bench.storage.merge import merge
from bench.study import matched as module
from bench.study.descriptions import noted
from bench.study.matched import algorithms, matched


def study(*optimizers, **changes):
    head = {"name": "s", "trials": 2, "budget": 60, "problems": [{"name": "sphere-2"}]}
    return Study.from_dict(head | {"optimizers": list(optimizers)} | changes)


def with_controls(own):
    return module.with_controls(own, check(Task.of(own)).descriptions)


def found(own):
    return matched(own, noted(own, {}))


BOX = {"name": "cma-es", "agents": 9, "handling": "box", "start": "midpoint"}
REPAIR = {"name": "gwo", "agents": 9}


def test_the_thesis_s_optimizers_run_under_each_other_s_conditions():
    controls = {each.label: each for each in with_controls(Study.load("thesis")).controls}
    assert [*controls] == ["alo (box)", "goa (box)", "gwo (box)", "da (box)", "cma-es (repair, random)"]
    assert controls["gwo (box)"].options == {"agents": 300, "handling": "box"}
    assert controls["cma-es (repair, random)"].options == {"agents": 300, "handling": "repair", "start": "random"}


def test_an_option_that_an_algorithm_lacks_is_named():
    box, repair = found(study(BOX, REPAIR))
    assert box.values == {"handling": "box", "start": "midpoint"}
    assert box.apart == {"cma-es": [], "gwo": ["start"]}
    assert repair.apart == {"cma-es": [], "gwo": []}
    assert {label: entry.label for label, entry in repair.entries.items()} == {
        "cma-es": "cma-es (repair, random)", "gwo": "gwo"
    }  # fmt: skip


def test_what_a_study_has_already_is_no_control():
    own = Study.load("thesis-equal")
    assert with_controls(own).controls == ()
    assert set(algorithms(own).values()) == {f"{name} 30" for name in ("cma-es", "alo", "goa", "gwo", "da")}
    assert [each.values for each in found(own)] == [{"agents": "30"}, {"agents": "100"}, {"agents": "300"}]
    assert found(own)[1].entries["gwo 30"].label == "gwo 100"


def test_nothing_is_missing_where_all_conditions_are_the_same():
    assert found(study(REPAIR, {"name": "da", "agents": 9})) == []
    assert found(study(REPAIR)) == []


def test_a_population_that_an_optimizer_chooses_is_shared_with_none():
    own = study({"name": "cma-es"}, REPAIR)
    assert [entry.label for entry in with_controls(own).controls] == ["cma-es (9 agents)"]


def test_a_value_that_an_algorithm_refuses_is_left_as_it_is():
    nine, two = found(study(REPAIR, {"name": "random-search", "agents": 2}))
    assert nine.entries["random-search"].label == "random-search (9 agents)"
    assert two.entries["gwo"].label == "gwo"  # which takes three at least
    assert two.apart == {"gwo": ["agents"], "random-search": []}


def test_a_stranger_takes_part_with_the_options_that_it_has(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def mine(objective, rng, handling='repair', step=0.1):\n    objective(objective.initial(1))\n")
    own = study({"name": f"{path}:mine", "label": "mine"}, {"name": "gwo", "handling": "box"})
    assert [entry.label for entry in with_controls(own).controls] == ["gwo (repair)", "mine (box)"]
    with pytest.raises(BenchError, match="unknown optimizer 'gone'"):
        with_controls(study({"name": "gone"}, BOX))


def test_controls_are_of_a_study_s_text_and_not_of_its_identity(tmp_path):
    own = study(BOX, REPAIR)
    more = with_controls(own)
    (tmp_path / "s.toml").write_text(more.to_toml())
    assert Study.load(tmp_path / "s.toml") == more
    assert more.identity() == own.identity()
    assert "controls" not in own.to_toml()
    seeds = {trial.key: trial.seed for trial in more.plan()}
    assert len(seeds) == 2 * 4
    assert all(seeds[trial.key] == trial.seed for trial in own.plan())


def test_a_label_is_of_one_optimizer_or_control():
    with pytest.raises(BenchError, match="'gwo' occurs twice among the optimizers and controls"):
        study(REPAIR, controls=[{"name": "gwo"}])
    with pytest.raises(BenchError, match="'da' occurs twice among the optimizers and controls"):
        study(REPAIR, controls=[{"name": "da"}]).beside(["da"])


TIMES = ["wall_s", "cpu_s", "objective_s"]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The study without controls, and the same folder once controls were added; no test changes them."""
    place = tmp_path_factory.mktemp("matched")
    own = study({"name": "random-search", "agents": 9, "handling": "box"}, {"name": "hill-climber"}, REPAIR)
    run(own, place / "without", jobs=1)
    run(own, place / "with", jobs=1)
    run(with_controls(own), place / "with", jobs=1)
    return own, place


@pytest.mark.slow
def test_a_folder_is_extended_and_no_other_trial_changes(folders):
    own, place = folders
    before, after = Results(place / "without"), Results(place / "with")
    pd.testing.assert_frame_equal(before.frame.drop(columns=TIMES), after.frame.drop(columns=TIMES))
    assert list(after.controls["optimizer"].unique()) == ["gwo (box)", "random-search (repair)"]
    assert len(after.everything) == len(after.origins) == len(after.frame) + len(after.controls)
    assert {key[1] for key in after.traces} == {entry.label for entry in own.optimizers}
    assert len(before.controls) == 0


@pytest.mark.slow
def test_a_run_without_controls_selects_none_and_keeps_their_trials(folders):
    own, place = folders
    whole = plan(own, place / "with")
    assert next(whole.missing(), None) is None
    assert ("sphere-2", "gwo (box)") not in whole.counts()
    assert any("gwo (box) is no longer in the study: its" in note for note in whole.notes)


@pytest.mark.slow
def test_folders_with_and_without_controls_are_merged(folders, tmp_path):
    _, place = folders
    merged = merge([place / "without", place / "with"], tmp_path / "both")
    assert merged.rows == len(Results(place / "with").everything)
    assert Folder(tmp_path / "both").study() == Folder(place / "with").study()
