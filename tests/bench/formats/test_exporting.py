"""What holds for every export format: where files go, what they replace, and what is refused."""

import re
from pathlib import Path

import pytest

from bench import BenchError, Results
from bench.formats import EXPORTABLE, FORMATS
from bench.formats.coco import writer as coco
from bench.formats.exporting import export
from bench.formats.trials import folders_of
from bench.helpers.text import file_name
from bench.storage.folder import Folder
from bench.study import Study
from tests.bench.formats.made import FAILED, HOSTILE, contents, exported, make, needs, some_fail


@pytest.mark.parametrize("folders", [folders_of, coco.optimizer_folders])
def test_no_two_optimizers_share_a_folder(folders, tmp_path):
    labels = (*HOSTILE, file_name("GWO"))  # the last is what another label's folder is called
    found = folders(make(tmp_path, optimizers=labels, trials=1))
    assert list(found) == list(labels)
    assert len(set(found.values())) == len(labels)
    assert all(re.fullmatch(r"[a-z0-9_][a-z0-9_-]*", name) for name in found.values())


@pytest.mark.parametrize("kind", EXPORTABLE)
class TestEveryFormat:
    def test_hostile_labels_stay_inside_and_are_named_in_the_readme(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", {"../../p": 2, "<b>": 2}, HOSTILE, trials=1)
        before = contents(tmp_path)
        folder = exported(results, kind, tmp_path / "deep" / "er" / "out")
        after = contents(tmp_path)
        assert {path for path in after if not path.startswith("deep/er/out/")} == set(before)
        readme = (folder / "README.txt").read_text(encoding="utf-8")
        assert all(label in readme for label in HOSTILE) == (kind in ("ioh", "coco"))

    def test_the_same_results_give_the_same_bytes(self, kind, tmp_path):
        needs(kind)
        make(tmp_path / "s", row=some_fail)
        first, second = (exported(Results(tmp_path / "s"), kind, tmp_path / name) for name in ("one", "two"))
        assert contents(first) == contents(second)
        assert Study.load(first / "study.toml") == Results(tmp_path / "s").study

    def test_an_earlier_export_is_replaced_and_nothing_else_is(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s")
        folder = exported(results, kind, tmp_path / "out")
        (folder / "stale").mkdir()
        (folder / "stale" / "old.info").write_text("x")
        fresh = contents(exported(results, kind, tmp_path / "other"))
        assert contents(exported(results, kind, folder)) == fresh
        for other in (tmp_path / "s", exported(results, "csv" if kind == "ioh" else "ioh", tmp_path / "third")):
            before = contents(other)
            with pytest.raises(BenchError, match="something other than an earlier export"):
                export(results, kind, other)
            assert contents(other) == before

    def test_the_folder_where_the_user_is_stays_the_same_folder(self, kind, tmp_path, monkeypatch):
        needs(kind)
        results = make(tmp_path / "s", trials=1)
        (tmp_path / "here").mkdir()
        monkeypatch.chdir(tmp_path / "here")
        before = Path().stat().st_ino
        for _ in range(2):
            export(results, kind, Path())
        assert Path(tmp_path / "here").stat().st_ino == before
        assert Path("README.txt").is_file()

    def test_failures_are_said(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", row=some_fail)
        notes = export(results, kind, tmp_path / "out")
        readme = (tmp_path / "out" / "README.txt").read_text(encoding="utf-8")
        if FORMATS[kind].writer.holds_failures:
            assert notes == []
        else:
            assert len(notes) == 1
            assert "4 of the trials of a (2 on sphere-2, 2 on p)" in notes[0]
            assert notes[0] in readme

    def test_a_study_of_nothing_but_failures(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", row=lambda *_: FAILED)
        if FORMATS[kind].writer.holds_failures:
            assert export(results, kind, tmp_path / "out") == []
        else:
            with pytest.raises(BenchError, match="no trial of this study finished"):
                export(results, kind, tmp_path / "out")
            assert not (tmp_path / "out").exists()

    def test_bad_input_is_one_sentence(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", trials=1)
        (tmp_path / "file").write_text("x")
        for place in (tmp_path / "file", tmp_path / "file" / "below"):
            with pytest.raises(BenchError, match="cannot be written"):
                export(results, kind, place)
        assert (tmp_path / "file").read_text() == "x"
        empty = Study("made", results.study.problems, results.study.optimizers)
        (tmp_path / "e").mkdir()
        Folder(tmp_path / "e").claim(empty)
        with Folder(tmp_path / "e").store.writer():
            pass
        with pytest.raises(BenchError, match="holds no trials yet"):
            export(Results(tmp_path / "e"), kind, tmp_path / "out")


def test_an_unknown_format_names_the_nearest(tmp_path):
    results = make(tmp_path / "s", trials=1)
    with pytest.raises(BenchError, match="'cvs'; did you mean 'csv'"):
        export(results, "cvs", tmp_path / "out")
    with pytest.raises(BenchError, match="known: coco, csv, ioh, parquet"):
        export(results, "xlsx", tmp_path / "out")
