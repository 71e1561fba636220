"""The diagnosis of a study's folder: kept for optimizers whose code and options have not changed."""

import json
from dataclasses import asdict

import pytest

from bench import Results, Study, run
from bench.check import folder as checked
from bench.check.bias import diagnose
from bench.check.folder import diagnose_folder
from bench.storage.folder import Folder
from tests.bench.check.biased import LITTLE

SIZES = {"dimension": 2, "runs": 1, "noise_runs": 3}


def diagnosed(folder, **given):
    """Return the diagnoses of a folder's optimizers from few runs."""
    return list(diagnose_folder(folder, **LITTLE, **SIZES, **given))


@pytest.fixture
def made(tmp_path):
    """Return a function that makes a folder of a study with these optimizers."""

    def make(*entries, trials=1):
        problems = [{"name": "sphere-3"}]
        study = {"name": "s", "trials": trials, "budget": 40, "problems": problems, "optimizers": list(entries)}
        run(Study.from_dict(study), tmp_path / "out", n_jobs=1)
        return Folder(tmp_path / "out")

    return make


def keys(folder):
    """Return the keys of the verdicts on a folder's optimizers."""
    study, held = folder.study(), folder.store.held()
    return {checked.key(entry, checked.made_from(held, entry.label)) for entry in study.optimizers}


def test_a_folder_keeps_the_verdicts_on_its_optimizers(made):
    folder = made({"name": "scatter", "agents": 7}, {"name": "early"})
    assert Results(folder.path).checks == {}
    found = diagnosed(folder)
    assert [(each.label, each.failed, each.kept) for each in found] == [("scatter", "", False), ("early", "", False)]
    assert found[0].verdicts == diagnose(folder.study().optimizer("scatter"), **LITTLE, **SIZES)
    noted = Results(folder.path).checks
    assert {each["code"] for those in noted.values() for each in those} == keys(folder)
    for each in found:
        assert [note | {"code": ""} for note in noted[each.label]] == [
            asdict(verdict) | {"code": ""} for verdict in each.verdicts
        ]


@pytest.mark.slow
def test_an_unchanged_optimizer_is_not_diagnosed_again_when_trials_are_added(made):
    first = diagnosed(made({"name": "scatter"}, {"name": "early"}))
    again = diagnosed(made({"name": "scatter"}, {"name": "early"}, trials=2))
    assert all(each.kept for each in again)
    assert [each.verdicts for each in again] == [each.verdicts for each in first]


@pytest.mark.slow
def test_a_changed_optimizer_alone_is_diagnosed_again(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = "def {0}(objective, rng, n=3):\n    while True: objective(objective.initial(n))\n"
    files = [tmp_path / "one.py", tmp_path / "two.py"]
    for file in files:
        file.write_text(code.format(file.stem))
    folder = made({"name": "one.py:one"}, {"name": "two.py:two"})
    assert not any(each.kept for each in diagnosed(folder))
    assert all(each.kept for each in diagnosed(folder))
    files[1].write_text(code.format("two") + "# not changed\n")
    assert all(each.kept for each in diagnosed(folder))
    files[1].write_text(code.format("two") + "CHANGED = 1\n")
    assert [(each.label, each.kept) for each in diagnosed(folder)] == [("one", True), ("two", False)]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("damage", [{"code": "0" * 16}, {"kind": "praise"}, {"passed": 1}, {"finding": None}])
def test_noted_verdicts_of_other_code_and_damaged_ones_are_not_kept(damage, made):
    folder = made({"name": "scatter"})
    diagnosed(folder)
    noted = json.loads((folder.path / "checks.json").read_text())
    noted["scatter"][1] |= damage
    (folder.path / "checks.json").write_text(json.dumps(noted))
    assert [each.kept for each in diagnosed(folder)] == [False]


def test_an_optimizer_that_fails_costs_the_others_nothing(made):
    folder = made({"name": "faulty"}, {"name": "scatter"})  # 'faulty' raises in two dimensions
    failed, sound = diagnosed(folder)
    assert (failed.label, failed.verdicts) == ("faulty", [])
    assert failed.failed == "the optimizer failed on sphere: RuntimeError: cannot do planes"
    assert (sound.label, sound.failed) == ("scatter", "")
    assert list(Results(folder.path).checks) == ["scatter"]


def test_an_optimizer_that_cannot_be_loaded_costs_the_others_nothing(made, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "gone.py").write_text("def gone(objective, rng):\n    while True: objective(objective.initial(3))\n")
    folder = made({"name": "gone.py:gone"}, {"name": "scatter"})
    diagnosed(folder)
    (tmp_path / "gone.py").unlink()
    gone, kept = diagnosed(folder)
    assert "gone.py" in gone.failed
    assert (kept.label, kept.failed, kept.kept) == ("scatter", "", True)
    assert list(Results(folder.path).checks) == ["scatter"]
