"""Files that are edited while a study runs: no two versions of code or data stand under one hash."""

import numpy as np
import pytest

from bench import BenchError, Study, load_results, run
from bench.execution.runner import plan
from bench.execution.verify import verify
from bench.plugins import registry

OPTIMIZER = (
    "def mine(objective, rng):\n    objective(objective.lower + {share} * (objective.upper - objective.lower))\n"
)
OTHER = (
    "from bench import FunctionProblem\n"
    "def other():\n    return FunctionProblem(lambda x: ((x - {share}) ** 2).sum(axis=1), [0], [1], name='other')\n"
)


LINKED = (
    "from dataclasses import dataclass\nfrom bench import Optimizer\n@dataclass(frozen=True)\nclass Walk(Optimizer):\n"
    "    def minimize(self, objective, rng):\n"
    "        objective(objective.lower + {share} * (objective.upper - objective.lower))\n"
)


@pytest.fixture
def study(tmp_path):
    """A study whose plug-ins' files are loaded again for the second problem, which is of another family."""
    (tmp_path / "mine.py").write_text(OPTIMIZER.format(share=0.25))
    (tmp_path / "other.py").write_text(OTHER.format(share=0.5))
    return Study.from_dict(
        {"name": "s", "trials": 2, "budget": 60,
         "problems": [{"name": "sphere-2"}, {"name": f"{tmp_path / 'other.py'}:other"}],
         "optimizers": [{"name": f"{tmp_path / 'mine.py'}:mine"}]}
    )  # fmt: skip


def test_an_edited_file_changes_no_trial_of_the_run_and_is_named(study, tmp_path):
    def edit(trial, row):
        (tmp_path / "mine.py").write_text(OPTIMIZER.format(share=0.75))
        (tmp_path / "other.py").write_text(OTHER.format(share=0.75))

    outcome = run(study, tmp_path / "out", n_jobs=1, on_trial=edit)
    assert sorted(outcome.edited) == [str(tmp_path / "mine.py"), str(tmp_path / "other.py")]
    assert load_results(tmp_path / "out").groupby("problem")["fun"].unique().map(list).to_dict() == {
        "other": [0.0625], "sphere-2": [12.5]
    }  # fmt: skip
    with pytest.raises(BenchError, match=r"mine changed \(mine.py\); other changed \(data\)"):
        verify(tmp_path / "out")
    assert run(study, tmp_path / "out").made == 4
    assert load_results(tmp_path / "out").groupby("problem")["fun"].unique().map(len).tolist() == [1, 1]


def test_a_file_that_is_removed_during_the_run_costs_no_trial(study, tmp_path):
    outcome = run(study, tmp_path / "out", n_jobs=1, on_trial=lambda *_: (tmp_path / "mine.py").unlink(missing_ok=True))
    assert (outcome.made, outcome.failed, outcome.edited) == (4, 0, [str(tmp_path / "mine.py")])


@pytest.mark.slow
def test_an_edited_helper_changes_no_trial_of_the_run_and_is_named(study, tmp_path):
    """Each process that loads the optimizer for another family of problems imports its helper anew."""
    (tmp_path / "mine.py").write_text("from helper_of_mine import SHARE\n" + OPTIMIZER.format(share="SHARE"))
    helper = tmp_path / "helper_of_mine.py"
    helper.write_text("SHARE = 0.25")
    outcome = run(study, tmp_path / "out", n_jobs=1, on_trial=lambda *_: helper.write_text("SHARE = 0.75"))
    assert outcome.edited == [str(helper)]
    assert load_results(tmp_path / "out").groupby("problem")["fun"].unique().map(list).to_dict() == {
        "other": [0.0625], "sphere-2": [12.5]
    }  # fmt: skip
    assert "mine changed (helper_of_mine.py) and is version 2 now: 4 trials to make" in " ".join(
        plan(study, tmp_path / "out").notes
    )
    helper.write_text("SHARE = 0.25  # of the box")
    assert run(study.override(trials=3), tmp_path / "out", n_jobs=1).made == 2


def test_a_helper_that_is_removed_during_the_run_costs_no_trial(study, tmp_path):
    (tmp_path / "mine.py").write_text("from pkg_of_mine.inner import SHARE\n" + OPTIMIZER.format(share="SHARE"))
    (tmp_path / "pkg_of_mine").mkdir()
    (tmp_path / "pkg_of_mine" / "__init__.py").write_text("")
    helper = tmp_path / "pkg_of_mine" / "inner.py"
    helper.write_text("SHARE = 0.25")
    outcome = run(study, tmp_path / "out", n_jobs=1, on_trial=lambda *_: helper.unlink(missing_ok=True))
    assert (outcome.made, outcome.failed, outcome.edited) == (4, 0, [str(helper)])


def test_an_optimizer_that_is_installed_as_a_link_to_its_checkout_is_edited_without_effect(tmp_path, monkeypatch):
    module, package = tmp_path / "linked_walk.py", tmp_path / "linked_walk-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: linked-walk\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[bench.optimizers]\nlinked-walk = linked_walk:Walk\n")
    module.write_text(LINKED.format(share=0.25))
    monkeypatch.syspath_prepend(tmp_path)
    registry.entries.cache_clear()
    problems = [{"name": "sphere-2"}, {"name": "classical-sphere-d2-i1"}]
    study = Study.from_dict(
        {"name": "s", "trials": 2, "budget": 60, "problems": problems, "optimizers": [{"name": "linked-walk"}]}
    )
    outcome = run(study, tmp_path / "out", n_jobs=1, on_trial=lambda *_: module.write_text(LINKED.format(share=0.75)))
    registry.entries.cache_clear()
    assert (outcome.made, outcome.failed, outcome.edited) == (4, 0, [str(module)])
    assert load_results(tmp_path / "out").groupby("problem")["x_x1"].unique().map(list).to_dict() == {
        "classical-sphere-d2-i1": [-2.56], "sphere-2": [-2.5]
    }  # fmt: skip


def test_data_that_change_before_a_process_loads_them_fail_its_trials(tmp_path):
    def record(frequency):
        t = np.arange(1000) * 0.002
        np.savetxt(tmp_path / "a.csv", np.column_stack([t, 100 + np.sin(frequency * t)]), delimiter=",")

    record(5.0)
    study = Study.from_dict(
        {"name": "s", "trials": 2, "budget": 60, "optimizers": [{"name": "scatter"}],
         "problems": [{"name": f"recording:{tmp_path / 'a.csv'}", "label": "recorded"}, {"name": "sphere-2"}]}
    )  # fmt: skip
    seeds = (study.override(seed=seed) for seed in range(100))
    chosen = next(each for each in seeds if next(each.plan()).problem == "sphere-2")
    outcome = run(chosen, tmp_path / "out", n_jobs=1, on_trial=lambda *_: record(7.0))
    frame = load_results(tmp_path / "out").set_index("problem")
    assert (outcome.made, outcome.failed) == (4, 2)
    assert frame.loc["recorded", "error"].str.contains("the data of problem 'recorded' changed while the study").all()
    assert frame.loc["sphere-2", "status"].eq("ok").all()
