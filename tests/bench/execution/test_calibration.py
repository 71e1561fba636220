"""How long a study takes, from short trials."""

from dataclasses import replace

import pytest

from bench import Study
from bench.execution.calibration import LEAST, SHARE, calibrated_seconds
from bench.execution.runner import plan
from bench.study.entries import Entry


def study(budget, problems=("sphere-2", "sphere-3"), optimizers=("scatter", "early"), **changes):
    return Study.from_dict(
        {"name": "s", "trials": 2, "budget": budget, "problems": [{"names": list(problems)}],
         "optimizers": [{"names": list(optimizers)}]} | changes
    )  # fmt: skip


@pytest.mark.parametrize(
    ("budget", "short"),
    [(60, 60), (LEAST, LEAST), (100_000, 5_000), ("1e5 * d", "5000 * d"), ("50 * d", "50 * d"),
     ({"2": 200_000, "3": 60}, {"2": 10_000, "3": 60})],
)  # fmt: skip
def test_a_short_trial_has_a_part_of_a_large_budget(budget, short):
    assert study(budget).budget.shortened(SHARE, LEAST) == short


@pytest.mark.slow
def test_it_counts_every_missing_trial_by_its_evaluations(tmp_path, testing_plugins):
    few = calibrated_seconds(plan(study(60), tmp_path / "a"), 1)
    many = calibrated_seconds(plan(study(60, trials=2000), tmp_path / "b"), 1)
    assert 0 < few < many
    assert not list(tmp_path.iterdir())


def test_without_a_short_trial_that_succeeds_there_is_none(tmp_path, testing_plugins):
    lost = study(60, problems=("sphere-2",), optimizers=("hostile",))
    assert calibrated_seconds(plan(lost, tmp_path / "a"), 1) is None


def test_a_search_without_an_end_is_stopped(tmp_path, testing_plugins, monkeypatch):
    monkeypatch.setattr("bench.execution.calibration.LONGEST", 1.0)
    monkeypatch.setattr("bench.execution.job.WARMING", 1.0)
    endless = replace(study(60, problems=("sphere-2",)), optimizers=(Entry("hostile", "hostile", {"deed": "spin"}),))
    assert calibrated_seconds(plan(endless, tmp_path / "a"), 1) is None
