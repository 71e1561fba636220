"""What strangers' plug-ins, labels and folders may do to a report: nothing beyond their own part."""

from types import SimpleNamespace

import matplotlib.figure
import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results, Study, run, write_report
from bench.report import Figure, Section, Table
from bench.study import Study as StudyClass
from bench.topics import write
from tests.bench.topics.test_write import patch_plugins


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


def text_of(page):
    return page.read_text(encoding="utf-8")


def problem(**changes):
    usual = {"optimum": 0.0, "expected": {}, "variables": ("a", "b"), "lower": np.zeros(2), "upper": np.ones(2)}
    usual |= {"features": {}, "integer": None, "noisy": False, "dimension": 2}
    return SimpleNamespace(**usual | changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"optimum": float("nan")}, {"optimum": float("-inf")}, {"optimum": "low"}, {"expected": {"radius": 3}},
        {"expected": None}, {"lower": "no"}, {"variables": ("a",)},
    ],
)  # fmt: skip
def test_a_problem_that_describes_itself_wrongly_is_only_unknown(folder, monkeypatch, changes):
    monkeypatch.setattr(StudyClass, "problem", lambda self, label: problem(**changes))
    known = Results(folder).facts("sphere-2")
    assert known.reason
    assert (known.optimum, known.expected, known.box) == (None, {}, {})


@pytest.mark.parametrize("output", [None, "own"])
def test_a_selection_replaces_no_report_of_the_whole_folder(folder, output):
    with pytest.raises(BenchError, match="give it a folder of its own by --output"):
        write_report(folder, optimizers="early", output=folder if output else None)
    assert not (folder / "report.html").exists()


def test_a_problem_that_raises_leaves_a_report_that_says_so(folder, monkeypatch, tmp_path):
    def fail(self, label):
        raise ZeroDivisionError("boom")

    monkeypatch.setattr(StudyClass, "problem", fail)
    page = text_of(write_report(folder, output=tmp_path / "out"))
    assert "1 problem cannot be loaded here" in page
    assert "ZeroDivisionError: boom" in page


@pytest.mark.sampled(1)
@pytest.mark.parametrize("entry", [None, 3, "@article{no"])
def test_an_optimizer_that_cites_itself_wrongly_is_not_cited(folder, monkeypatch, tmp_path, entry):
    monkeypatch.setattr(StudyClass, "optimizer", lambda self, label: SimpleNamespace(bibtex=entry))
    write_report(folder, output=tmp_path / "out")
    assert "scatter" in (tmp_path / "out" / "methods.md").read_text()


@pytest.mark.slow
def test_a_section_that_fails_half_way_leaves_no_download(folder, monkeypatch, tmp_path):
    def sections(findings):
        yield Section("Good", items=(Table("mine", "Mine.", pd.DataFrame({"a": [1]})),))
        raise ValueError("later")

    patch_plugins(monkeypatch, half=sections)
    page = text_of(write_report(folder, output=tmp_path / "out"))
    assert "The report section &#39;half&#39; failed and is left out" in page
    assert "ValueError: later" in page
    assert "tables/mine.csv" not in page
    assert not (tmp_path / "out" / "tables" / "mine.csv").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("draws")
def test_a_figure_that_cannot_be_drawn_costs_its_own_section_alone(folder, monkeypatch, tmp_path):
    def sections(findings):
        wrong = matplotlib.figure.Figure()
        wrong.suptitle("$\\frac{$")  # is no mathematics
        return [Section("Bad", items=(Figure("wrong", "Wrong.", wrong, pd.DataFrame({"a": [1]})),))]

    monkeypatch.setattr(write, "FEW", 0)
    patch_plugins(monkeypatch, bad=sections)
    page = text_of(write_report(folder, output=tmp_path / "out", n_jobs=2))
    assert "The report section &#39;bad&#39; failed and is left out" in page
    assert (tmp_path / "out" / "figures" / "every-run.svg").exists()
    assert not list((tmp_path / "out" / "figures").glob("wrong*"))


def test_a_folder_with_other_files_is_left_alone(folder, tmp_path):
    (tmp_path / "references.bib").write_text("mine")
    with pytest.raises(BenchError, match="holds other files"):
        write_report(folder, output=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["references.bib"]


@pytest.mark.slow
def test_an_interrupted_report_can_be_written_again(folder, monkeypatch, tmp_path):
    def interrupt(*arguments):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("bench.report.write.render", interrupt)
        with pytest.raises(KeyboardInterrupt):
            write_report(folder, output=tmp_path / "out")
    assert write_report(folder, output=tmp_path / "out").exists()


@pytest.mark.slow
def test_steps_are_told_before_their_work_and_end_at_their_number(folder, tmp_path):
    steps = []
    write_report(folder, output=tmp_path / "out", on_progress=lambda *step: steps.append(step))
    titles, done, totals = zip(*steps, strict=True)
    assert (titles[0], titles[-1]) == ("Answer", "The page")
    assert done == tuple(range(len(steps)))
    assert set(totals) == {len(steps)}
