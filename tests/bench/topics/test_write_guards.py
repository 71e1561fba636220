"""What strangers' plug-ins, labels and folders may do to a report: nothing beyond their own part."""

import pytest

from bench import BenchError, Study, run, write_report


@pytest.fixture(scope="module")
def folder(tmp_path_factory, testing_plugins):
    """Return the folder of a small finished study."""
    study = {
        "name": "small", "trials": 2, "budget": 30, "problems": [{"name": "sphere-2"}],
        "optimizers": [{"name": "scatter", "agents": 5}, {"name": "early"}],
    }  # fmt: skip
    place = tmp_path_factory.mktemp("runs") / "small"
    run(Study.from_dict(study), place, n_jobs=1)
    return place


def test_a_folder_with_other_files_is_left_alone(folder, tmp_path):
    (tmp_path / "references.bib").write_text("mine")
    with pytest.raises(BenchError, match="holds other files"):
        write_report(folder, output=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["references.bib"]


@pytest.mark.slow
def test_steps_are_told_before_their_work_and_end_at_their_number(folder, tmp_path):
    steps = []
    write_report(folder, output=tmp_path / "out", on_progress=lambda *step: steps.append(step))
    titles, done, totals = zip(*steps, strict=True)
    assert (titles[0], titles[-1]) == ("Answer", "The page")
    assert done == tuple(range(len(steps)))
    assert set(totals) == {len(steps)}


@pytest.mark.parametrize("output", [None, "own"])
def test_a_selection_replaces_no_report_of_the_whole_folder(folder, output):
    with pytest.raises(BenchError, match="give it a folder of its own by --output"):
        write_report(folder, optimizers="early", output=folder if output else None)
    assert not (folder / "report.html").exists()
