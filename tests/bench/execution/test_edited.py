"""Files that are edited while a study runs: rows say what they were made from, and no version holds two codes."""

import numpy as np
import pytest

from bench import BenchError, Study, load_results, run
from bench.execution.runner import plan
from bench.execution.verify import verify
from bench.helpers.atomic import replacing
from bench.storage.folder import Folder
from tests.bench.made import Heard

OPTIMIZER = (
    "def mine(objective, rng):\n    objective(objective.lower + {share} * (objective.upper - objective.lower))\n"
)
OTHER = (
    "from bench import FunctionProblem\n"
    "def other():\n    return FunctionProblem(lambda x: ((x - {share}) ** 2).sum(axis=1), [0], [1], name='other')\n"
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


def values_by_version(path):
    """Return the values of every stored cell, selected or not, each as a set."""
    found = {}
    with Folder(path).store.reader() as reader:
        for cell, row in reader.sound():
            found.setdefault(cell, set()).add(row["fun"])
    return list(found.values())


def test_an_edit_costs_no_trial_is_named_and_mixes_no_two_codes(study, tmp_path):
    def edit(trial, row):
        for name, text in (("mine.py", OPTIMIZER), ("other.py", OTHER)):
            with replacing(tmp_path / name) as written:  # no process reads half a file
                written.write_text(text.format(share=0.75))

    outcome = run(study, tmp_path / "out", n_jobs=1, progress=Heard(edit))
    assert (outcome.made, outcome.failed) == (4, 0)
    assert {name.rpartition("/")[2] for name in outcome.edited} <= {"mine.py", "other.py"} != set()
    assert all(len(values) == 1 for values in values_by_version(tmp_path / "out"))
    with pytest.raises(BenchError, match=r"mine changed \(.*mine.py\)"):
        verify(tmp_path / "out")
    again = run(study, tmp_path / "out", n_jobs=1)
    assert 0 < again.made < 4  # what was made with the new files is not made again
    assert load_results(tmp_path / "out").groupby("problem")["fun"].unique().map(list).to_dict() == {
        "other": [0.0], "sphere-2": [12.5]
    }  # fmt: skip
    assert all(len(values) == 1 for values in values_by_version(tmp_path / "out"))


@pytest.mark.slow
def test_data_that_change_before_a_process_loads_them_make_another_version(tmp_path):
    def record(frequency):
        t = np.arange(1000) * 0.002
        np.savetxt(tmp_path / "a.csv", np.column_stack([t, 100 + np.sin(frequency * t)]), delimiter=",")

    record(5.0)
    study = Study.from_dict(
        {"name": "s", "trials": 2, "budget": 60, "optimizers": [{"name": "scatter"}],
         "problems": [{"name": f"recording:{tmp_path / 'a.csv'}", "label": "recorded"}, {"name": "sphere-2"}]}
    )  # fmt: skip
    run(study, tmp_path / "out", n_jobs=1)
    record(7.0)
    [note] = plan(study, tmp_path / "out").notes
    assert note == f"recorded changed ({tmp_path / 'a.csv'}): 2 trials to make; the 2 before are kept"
    assert run(study, tmp_path / "out", n_jobs=1).made == 2
    assert len(values_by_version(tmp_path / "out")) == 3
