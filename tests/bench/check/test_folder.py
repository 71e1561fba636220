"""The diagnosis of a study's folder: kept for optimizers whose code and options have not changed."""

import json
from dataclasses import asdict

import pytest

from bench import BenchError, Results, Study, run
from bench.check import folder as checked
from bench.check.bias import diagnose, diagnose_all
from bench.check.folder import diagnose_folder
from bench.check.verdict import Verdict
from bench.storage.folder import Folder

SIZES = {"dimension": 2, "runs": 1, "noise_runs": 3}
pytestmark = pytest.mark.usefixtures("little_work", "in_this_process")


@pytest.fixture
def asked(monkeypatch):
    """Make few runs; return the optimizers that were diagnosed."""
    asked = []

    def few(optimizers, n_jobs, **given):
        asked.extend(optimizers)
        return diagnose_all(optimizers, n_jobs=n_jobs, **(SIZES | given))

    monkeypatch.setattr("bench.check.bias.diagnose_all", few)
    return asked


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
    return {
        checked.key(entry, study.optimizer(entry.label), checked.made_from(held, entry.label))
        for entry in study.optimizers
    }


def test_a_folder_keeps_the_verdicts_on_its_optimizers(made, asked):
    folder = made({"name": "scatter", "agents": 7}, {"name": "early"})
    assert Results(folder.path).checks == {}
    found = list(diagnose_folder(folder, n_jobs=1))
    assert [(each.label, each.failed, each.kept) for each in found] == [("scatter", "", False), ("early", "", False)]
    assert found[0].verdicts == diagnose(folder.study().optimizer("scatter"), n_jobs=1, **SIZES)
    noted = Results(folder.path).checks
    assert {each["code"] for those in noted.values() for each in those} == keys(folder)
    for each in found:
        assert [note | {"code": ""} for note in noted[each.label]] == [
            asdict(verdict) | {"code": ""} for verdict in each.verdicts
        ]


@pytest.mark.slow
def test_an_unchanged_optimizer_is_not_diagnosed_again_when_trials_are_added(made, asked):
    first = list(diagnose_folder(made({"name": "scatter"}, {"name": "early"}), n_jobs=1))
    again = list(diagnose_folder(made({"name": "scatter"}, {"name": "early"}, trials=2), n_jobs=1))
    assert len(asked) == 2
    assert all(each.kept for each in again)
    assert [each.verdicts for each in again] == [each.verdicts for each in first]


def test_the_user_may_ask_for_a_diagnosis_anew(made, asked):
    folder = made({"name": "scatter"})
    for anew in (False, True):
        (found,) = diagnose_folder(folder, n_jobs=1, anew=anew)
        assert not found.kept
    assert len(asked) == 2


@pytest.mark.slow
def test_a_changed_optimizer_alone_is_diagnosed_again(made, asked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = "def {0}(objective, rng, n=3):\n    while True: objective(objective.initial(n))\n"
    files = [tmp_path / "one.py", tmp_path / "two.py"]
    for file in files:
        file.write_text(code.format(file.stem))
    folder = made({"name": "one.py:one"}, {"name": "two.py:two"})
    assert not any(each.kept for each in diagnose_folder(folder, n_jobs=1))
    assert all(each.kept for each in diagnose_folder(folder, n_jobs=1))
    files[1].write_text(code.format("two") + "# not changed\n")
    assert all(each.kept for each in diagnose_folder(folder, n_jobs=1))
    files[1].write_text(code.format("two") + "CHANGED = 1\n")
    assert [(each.label, each.kept) for each in diagnose_folder(folder, n_jobs=1)] == [("one", True), ("two", False)]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("damage", [{"code": "0" * 16}, {"kind": "praise"}, {"passed": 1}, {"finding": None}])
def test_noted_verdicts_of_other_code_and_damaged_ones_are_not_kept(damage, made, asked):
    folder = made({"name": "scatter"})
    list(diagnose_folder(folder, n_jobs=1))
    noted = json.loads((folder.path / "checks.json").read_text())
    noted["scatter"][1] |= damage
    (folder.path / "checks.json").write_text(json.dumps(noted))
    assert [each.kept for each in diagnose_folder(folder, n_jobs=1)] == [False]


@pytest.mark.slow
def test_the_key_depends_on_options_and_on_the_code_of_the_harness(made, monkeypatch):
    folder = made({"name": "scatter", "label": "a"}, {"name": "scatter", "label": "b", "agents": 7})
    before = keys(folder)
    assert len(before - {""}) == 2
    monkeypatch.setattr("bench.storage.provenance.package", lambda: "backlash-bench 9 (code 0)")
    assert not before & keys(folder)


def test_what_was_diagnosed_before_an_interrupt_is_kept(made, asked, monkeypatch):
    folder = made({"name": "scatter"}, {"name": "early"})
    found = diagnose_folder(folder, n_jobs=1)
    next(found)
    found.close()
    assert [(each.label, each.kept) for each in diagnose_folder(folder, n_jobs=1)] == [
        ("scatter", True), ("early", False)
    ]  # fmt: skip


def test_what_is_no_verdict_is_passed_over(tmp_path, small_study):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    one = Verdict("starts and seeds", "bias", True, "every run starts at the same point").as_dict() | {"code": "12ab"}
    others = [one | {"check": 3}, one | {"passed": "no"}, one | {"figure": "50"}, {}, 5]
    notes = {"scatter": [one, *others], "early": 5, "stranger": [one]}
    (tmp_path / "out" / "checks.json").write_text(json.dumps(notes))
    assert Results(tmp_path / "out").checks == {"scatter": [one]}


def test_an_optimizer_that_fails_costs_the_others_nothing(made, asked):
    folder = made({"name": "faulty"}, {"name": "scatter"})  # 'faulty' raises in two dimensions
    failed, sound = diagnose_folder(folder, n_jobs=1)
    assert (failed.label, failed.verdicts) == ("faulty", [])
    assert failed.failed == "the optimizer failed on sphere: RuntimeError: cannot do planes"
    assert (sound.label, sound.failed) == ("scatter", "")
    assert list(Results(folder.path).checks) == ["scatter"]


def test_an_optimizer_that_cannot_be_loaded_costs_the_others_nothing(made, asked, monkeypatch):
    folder, load = made({"name": "early"}, {"name": "scatter"}), Study.optimizer

    def optimizer(study, label):
        if label == "early":
            raise BenchError("it is gone")
        return load(study, label)

    list(diagnose_folder(folder, n_jobs=1))
    monkeypatch.setattr(Study, "optimizer", optimizer)
    assert [(each.label, each.failed, each.kept) for each in diagnose_folder(folder, n_jobs=1)] == [
        ("early", "it is gone", False), ("scatter", "", True)
    ]  # fmt: skip
    assert list(Results(folder.path).checks) == ["scatter"]
