"""Every honest change of code or data between two runs is named, or found by a trial that is made again."""

import os
import shutil

import pytest

from bench import Study, run
from bench.execution.runner import plan
from tests.bench.execution.changes import FIRST, OWN, VARIABLES, apply, place
from tests.bench.storage.changes import forge


def studied(folder, changes, trials=1):
    optimizers = [
        {"name": f"{place(folder / str(number), change)}:mine", "label": name}
        for number, (name, change) in enumerate(changes.items())
    ]
    return Study.from_dict(
        {"name": "s", "trials": trials, "budget": 20, "problems": [{"name": "sphere-2"}], "optimizers": optimizers}
    )


class Changed:
    """A study that was run, then changed: what its plan says, and what the second net alone finds."""

    def __init__(self, folder, changes):
        os.environ.update(VARIABLES)
        study = studied(folder / "code", changes)
        first = run(study, folder / "out", n_jobs=2, verify=False)
        assert first.failed == 0
        again = plan(study, folder / "out")
        assert list(again.missing()) == []
        assert again.notes == []
        shutil.copytree(folder / "out", folder / "blind")
        for number, change in enumerate(changes.values()):
            apply(folder / "code" / str(number), change)
        notes = plan(study, folder / "out").notes
        self.said = {
            name: next((note for note in notes if note.startswith(f"{name} changed (")), "") for name in changes
        }
        self.net = self.caught(study, folder / "out")
        forge(folder / "blind" / "trials.sqlite", "UPDATE results SET inputs = NULL")
        self.blind = self.caught(study, folder / "blind")

    @staticmethod
    def caught(study, path):
        """Return the optimizers that get no second trial, as their first one differs."""
        lines = run(study.override(trials=2), path, n_jobs=2, verify=False).doubtful
        return {line.partition(" on sphere-2")[0].removeprefix("different: ") for line in lines}


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    before = dict(os.environ)
    yield Changed(tmp_path_factory.mktemp("changed"), FIRST | OWN)
    for name in os.environ.keys() - before.keys():
        del os.environ[name]


@pytest.mark.slow
@pytest.mark.parametrize("name", FIRST | OWN)
def test_it_is_named_or_found(name, changed):
    named = (FIRST | OWN)[name].named
    if named:
        assert named in changed.said[name].partition("):")[0], changed.said[name]
    else:
        assert name in changed.net


@pytest.mark.slow
def test_the_second_net_alone_finds_most_of_them(changed):
    assert len(changed.blind & FIRST.keys()) >= 15, sorted(FIRST.keys() - changed.blind)


def test_three_changes_are_named_or_found(tmp_path, monkeypatch):
    for name in (*VARIABLES, "BENCH_TEST_LATER"):
        monkeypatch.setenv(name, VARIABLES.get(name, "0.25"))
    few = {name: (FIRST | OWN)[name] for name in ("sys.path.insert", "read_csv", "variable", "what C opens")}
    found = Changed(tmp_path, few)
    assert [few[name].named in found.said[name] for name in few if few[name].named] == [True] * 3
    assert found.net == {"what C opens"}
    assert found.blind == {*few}
