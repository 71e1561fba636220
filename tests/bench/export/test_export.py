"""Exports, read back with pandas and with the real iohinspector and cocopp, each in a process of its own."""

import json
import math
import os
import re
import subprocess
import sys
from dataclasses import replace
from importlib.util import find_spec
from itertools import accumulate

import numpy as np
import pandas as pd
import pytest

import bench
from bench import BenchError, Results, Trace
from bench.export import FORMATS, coco, export, ioh, tabular
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.text import file_name

HOSTILE = ("gwo", "GWO", "../../x", "<script>", "日本", "database", "base", "dat-abase", "'q', a = \"1\"", "NA")
BUDGET = 120

# The readers run apart: they set up matplotlib for themselves, and cocopp asks the network and writes to the home.
ISOLATE = """
import json, os, socket, sys, warnings
def refuse(*args, **kwargs): raise OSError("no network")
socket.getaddrinfo = refuse
os.environ["HOME"] = os.environ["USERPROFILE"] = sys.argv[2]
"""
READ_IOH = """
from types import ModuleType
for name in ("metrics", "plots", "indicators"):  # slow to import, and no part of the reader
    sys.modules[f"iohinspector.{name}"] = ModuleType(name)
import iohinspector
warnings.simplefilter("error")
manager = iohinspector.DataManager()
manager.add_folder(sys.argv[1])
rows = {}
for row in manager.load(monotonic=False, include_meta_data=True).iter_rows(named=True):
    key = f"{row['function_name']}|{row['algorithm_name']}|{row['run_id'] - 1}"
    rows.setdefault(key, []).append((row["evaluations"], row["raw_y"]))
print(json.dumps({"overview": manager.overview.to_dicts(), "rows": rows}))
"""
READ_COCO = """
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cocopp
    cocopp.archiving.official_archives.bbob
warnings.simplefilter("error")
cocopp.genericsettings.warning_level = 0
targets, found = json.loads(sys.argv[3]), []
for name in sorted(os.listdir(sys.argv[1])):
    if os.path.isdir(folder := os.path.join(sys.argv[1], name)):
        for data in cocopp.pproc.DataSetList(folder):
            found.append({
                "function": data.funcId, "dimension": data.dim, "folder": name, "algorithm": data.algId,
                "spent": data.maxevals.tolist(), "finals": data.finalfunvals.tolist(), "ert": data.detERT(targets),
                "funvals": data.funvals.tolist(),
            })
last = cocopp.testbedsettings.CONSBBOBTestbed.settings["last_function_number"]
print("\\n" + json.dumps({"sets": found, "last": last}))
"""


def read(script, folder, home, *arguments):
    """Return what a reader's script prints last, as JSON."""
    command = [sys.executable, "-c", ISOLATE + script, str(folder), str(home), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONUTF8": "1"})
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def search(rng, length):
    """Return the values of a made-up search that closes in on 0 and begins with infinite ones."""
    return np.concatenate(
        ([np.inf] * int(rng.integers(0, 3)), np.exp(3 * rng.normal(size=length) - np.arange(length) / 9))
    )


def record(values, d, **changes):
    best = list(accumulate(values, min))
    at = [i for i, value in enumerate(best) if value < (best[i - 1] if i else math.inf)]
    trace = Trace(np.array(at, dtype=np.int64) + 1, np.array([best[i] for i in at], dtype=np.float64))
    return {
        "status": "ok", "fun": best[-1], "nfev": len(values), "wall_s": 0.1 + 0.2, "cpu_s": 1 / 3, "objective_s": 1e-9,
        "stop": "budget", "outside_box": 0, "x": {f"x{i}": i / 7 for i in range(d)}, "figures": {}, "trace": trace,
    } | changes  # fmt: skip


FAILED = {"status": "failed", "error": 'ValueError: boom, "really"\r\n\tTraceback\rmore'}


def make(folder, problems=None, optimizers=("a", "b"), trials=4, row=None):
    """Write a study; ``problems`` maps labels to dimensions, ``row`` may give a trial's row."""
    problems = problems or {"sphere-2": 2, "p": 3}
    entries = tuple(Entry(label, label) for label in problems), tuple(Entry("any", label) for label in optimizers)
    study, rng = Study("made", *entries, trials=trials, budget=BUDGET), np.random.default_rng(0)
    place = Folder(folder)
    place.path.mkdir(parents=True, exist_ok=True)
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            values = search(rng, int(rng.integers(1, BUDGET - 3)))
            given = row(trial, values) if row else None
            writer.add(trial, given or record(values, problems[trial.problem]))
    return Results(folder)


def contents(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def some_fail(trial, values):
    if trial.optimizer == "a" and trial.number in (1, 2):
        return FAILED
    return record([math.inf] * 7, 2) if trial.problem == "never" else None


class TestNames:
    @pytest.mark.parametrize("folders", [ioh.optimizer_folders, coco.optimizer_folders])
    def test_no_two_optimizers_share_a_folder(self, folders, tmp_path):
        labels = (*HOSTILE, file_name("GWO"))  # the last is what another label's folder is called
        found = folders(make(tmp_path, optimizers=labels, trials=1))
        assert list(found) == list(labels)
        assert len(set(found.values())) == len(labels)
        assert all(re.fullmatch(r"[a-z0-9_][a-z0-9_-]*", name) for name in found.values())


@pytest.mark.parametrize("kind", FORMATS)
class TestEveryFormat:
    def test_hostile_labels_stay_inside_and_are_named_in_the_readme(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", {"../../p": 2, "<b>": 2}, HOSTILE, trials=1)
        before = contents(tmp_path)
        folder = export(results, kind, tmp_path / "deep" / "er" / "out").folder
        after = contents(tmp_path)
        assert {path for path in after if not path.startswith("deep/er/out/")} == set(before)
        readme = (folder / "README.txt").read_text(encoding="utf-8")
        assert all(label in readme for label in HOSTILE) == (kind in ("ioh", "coco"))

    def test_the_same_results_give_the_same_bytes(self, kind, tmp_path):
        needs(kind)
        make(tmp_path / "s", row=some_fail)
        first, second = (export(Results(tmp_path / "s"), kind, tmp_path / name).folder for name in ("one", "two"))
        assert contents(first) == contents(second)
        assert Study.load(first / "study.toml") == Results(tmp_path / "s").study

    def test_an_earlier_export_is_replaced_and_nothing_else_is(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s")
        folder = export(results, kind, tmp_path / "out").folder
        (folder / "stale").mkdir()
        (folder / "stale" / "old.info").write_text("x")
        fresh = contents(export(results, kind, tmp_path / "other").folder)
        assert contents(export(results, kind, folder).folder) == fresh
        for other in (tmp_path / "s", export(results, "csv" if kind == "ioh" else "ioh", tmp_path / "third").folder):
            before = contents(other)
            with pytest.raises(BenchError, match="something other than an earlier export"):
                export(results, kind, other)
            assert contents(other) == before

    def test_failures_are_said(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", row=some_fail)
        done = export(results, kind, tmp_path / "out")
        readme = (done.folder / "README.txt").read_text(encoding="utf-8")
        if FORMATS[kind].holds_failures:
            assert done.notes == []
        else:
            assert len(done.notes) == 1
            assert "4 of the trials of a (2 on sphere-2, 2 on p)" in done.notes[0]
            assert done.notes[0] in readme

    def test_a_study_of_nothing_but_failures(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", row=lambda *_: FAILED)
        if FORMATS[kind].holds_failures:
            assert export(results, kind, tmp_path / "out").notes == []
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


def needs(kind):
    if kind == "parquet":
        pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")


def test_an_unknown_format_names_the_nearest(tmp_path):
    results = make(tmp_path / "s", trials=1)
    with pytest.raises(BenchError, match="'cvs'; did you mean 'csv'"):
        export(results, "cvs", tmp_path / "out")
    with pytest.raises(BenchError, match="known: coco, csv, ioh, parquet"):
        export(results, "xlsx", tmp_path / "out")


def test_more_problems_than_the_ioh_format_numbers_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(ioh, "LARGEST_FUNCTION", 1)
    with pytest.raises(BenchError, match="at most 1 problems"):
        export(make(tmp_path / "s", trials=1), "ioh", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_parquet_without_pyarrow_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BenchError, match=re.escape("pip install 'backlash-bench[parquet]'")):
        export(make(tmp_path / "s", trials=1), "parquet", tmp_path / "out")
    assert not (tmp_path / "out").exists()


class TestTables:
    @pytest.mark.parametrize("kind", ["csv", "parquet"])
    def test_everything_comes_back(self, kind, tmp_path):
        needs(kind)
        results = make(tmp_path / "s", {"sphere-2": 2, "never": 2}, ("NA", "a"), row=some_fail)
        folder = export(results, kind, tmp_path / "out").folder
        if kind == "csv":  # every float by Python's own reader, which rounds correctly in every version
            trials, improvements = (
                pd.read_csv(folder / f"{name}.csv", dtype=str, keep_default_na=False).replace({"": None})
                for name in ("trials", "improvements")
            )
            improvements = improvements.astype({"trial": int, "evaluations": int, "value": object})
            improvements["value"] = [float(text) for text in improvements["value"]]
        else:
            trials, improvements = (pd.read_parquet(folder / f"{name}.parquet") for name in ("trials", "improvements"))
        frame = results.frame
        assert list(trials) == list(frame)
        assert np.isinf(frame["fun"]).sum() == 6  # of 'never', two of whose eight trials failed
        for name in frame:
            if name == "error":
                ends = frame[name].str.replace("\r\n", "\n").str.replace("\r", "\n")
                assert trials[name].fillna("").tolist() == ends.fillna("").tolist()
            elif name in tabular.TEXTS:
                assert trials[name].fillna("").tolist() == frame[name].fillna("").tolist()
            else:
                values = [math.nan if pd.isna(value) else float(value) for value in trials[name]]
                np.testing.assert_array_equal(values, frame[name].to_numpy(float))
        assert [int(seed) for seed in trials["seed"]] == frame["seed"].tolist()  # more digits than a float holds
        assert list(improvements) == ["problem", "optimizer", "trial", "evaluations", "value"]
        kept = {key: trace for key, trace in results.traces.items() if len(trace.values)}
        groups = dict(list(improvements.groupby(["problem", "optimizer", "trial"])))
        assert groups.keys() == kept.keys()
        for key, trace in kept.items():
            assert groups[key]["evaluations"].tolist() == trace.evaluations.tolist()
            assert groups[key]["value"].tolist() == trace.values.tolist()

    def test_counts_are_whole_numbers_beside_failures(self, tmp_path):
        folder = export(make(tmp_path / "s", row=some_fail), "csv", tmp_path / "out").folder
        text = pd.read_csv(folder / "trials.csv", dtype=str)
        assert text["nfev"].dropna().str.fullmatch(r"\d+").all()
        assert text["nfev"].isna().sum() == 4

    def test_parquet_keeps_types_even_of_columns_without_values(self, tmp_path):
        needs("parquet")
        import pyarrow.parquet as pq

        folder = export(make(tmp_path / "s", row=lambda *_: FAILED), "parquet", tmp_path / "out").folder
        types = {field.name: str(field.type) for field in pq.read_schema(folder / "trials.parquet")}
        assert types["stop"].removeprefix("large_") == "string"
        assert types["nfev"] == types["seed"] == "int64"
        improvements = pq.read_table(folder / "improvements.parquet")
        assert improvements.num_rows == 0
        assert [str(field.type).removeprefix("large_") for field in improvements.schema] == [
            "string", "string", "int64", "int64", "double",
        ]  # fmt: skip

    def test_a_real_run(self, small_study, tmp_path):
        bench.run(replace(small_study, trials=1), tmp_path / "s", n_jobs=1)
        results = Results(tmp_path / "s")
        folder = export(results, "csv", tmp_path / "out").folder
        texts = pd.read_csv(folder / "trials.csv", dtype=str)
        for name in ("fun", "wall_s", "x_x1", "radius"):
            assert [float(text) for text in texts[name]] == results.frame[name].tolist()
        assert json.loads((folder / "environment.json").read_text())[0]["packages"]["backlash-bench"]


@pytest.fixture(scope="module")
def ioh_read(tmp_path_factory):
    place = tmp_path_factory.mktemp("ioh")
    results = make(place / "s", {"sphere-2": 2, "../../p": 3, "never": 2}, (*HOSTILE, "a"), row=some_fail)
    folder = export(results, "ioh", place / "out").folder
    return results, read(READ_IOH, folder, place)


@pytest.mark.skipif(find_spec("iohinspector") is None, reason="reads the ioh format with iohinspector")
class TestIOH:
    def test_every_finished_trial_is_found_with_its_exact_figures(self, ioh_read):
        results, found = ioh_read
        finished = results.frame[results.frame["status"] == "ok"]
        dimensions = {"sphere-2": 2, "../../p": 3, "never": 2}
        expected = sorted(
            (row.problem, row.optimizer, row.nfev, row.fun if math.isfinite(row.fun) else -1, dimensions[row.problem])
            for row in finished.itertuples()
        )
        columns = ("function_name", "algorithm_name", "evals", "best_y", "dimension")
        rows = [tuple(-1 if row[name] is None else row[name] for name in columns) for row in found["overview"]]
        assert sorted(rows) == expected
        numbers = {row["function_id"]: row["function_name"] for row in found["overview"]}
        assert numbers == {1: "sphere-2", 2: "../../p", 3: "never"}
        assert {row["instance"] for row in found["overview"]} == {1}

    def test_every_improvement_is_found_bit_for_bit(self, ioh_read):
        results, found = ioh_read
        finished = results.frame[results.frame["status"] == "ok"]
        assert len(found["rows"]) == len(finished)
        for (problem, optimizer), rows in finished.groupby(["problem", "optimizer"]):
            for run, row in enumerate(rows.itertuples()):
                trace = results.traces[problem, optimizer, row.trial]
                evaluations, values = zip(*found["rows"][f"{problem}|{optimizer}|{run}"], strict=True)
                assert list(values) == trace.at(evaluations).tolist()
                assert set(evaluations) == {1, *trace.evaluations.tolist(), row.nfev}
                assert list(evaluations) == sorted(set(evaluations))

    def test_the_commit_is_told(self, tmp_path):
        results = make(tmp_path / "s", trials=1)
        environments = [
            {},
            {"git": None},
            *({"git": {"commit": "0a1", "dirty": dirty}} for dirty in (False, True, False)),
        ]
        results.environments[:] = environments
        folder = export(results, "ioh", tmp_path / "out").folder
        head = json.loads(next(folder.glob("a/*.json")).read_text())
        assert head["experiment_attributes"] == [{"git_sha": "0a1+0a1-dirty"}]


TARGETS = [100.0, 1.0, 0.1, 1e-3]
TRIGGERS = sorted({math.floor(10 ** (i / 20) + 1e-9) for i in range(62)})  # to 1122


@pytest.fixture(scope="module")
def coco_read(tmp_path_factory):
    place = tmp_path_factory.mktemp("coco")
    results = make(place / "s", {"sphere-2": 2, "../../p": 7, "never": 2}, (*HOSTILE, "a"), row=some_fail)
    folder = export(results, "coco", place / "out").folder
    return results, read(READ_COCO, folder, place, json.dumps(TARGETS))


@pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads the coco format with cocopp and six")
class TestCOCO:
    @staticmethod
    def traces(results, data):
        problem = results.study.problems[data["function"] - 1].label
        folders = {folder: label for label, folder in coco.optimizer_folders(results).items()}
        here = results.frame.query("problem == @problem and status == 'ok'", engine="python")
        here = here[here["optimizer"] == folders[data["folder"]]]
        return problem, [(results.traces[problem, row.optimizer, row.trial], row) for row in here.itertuples()]

    def test_every_cell_and_trial_is_found(self, coco_read):
        results, found = coco_read
        assert len(found["sets"]) == 3 * len(results.study.optimizers)
        assert len({data["algorithm"] for data in found["sets"]}) == len(results.study.optimizers)
        for data in found["sets"]:
            _, runs = self.traces(results, data)
            assert data["spent"] == [row.nfev for _, row in runs]
            assert data["dimension"] == (2, 7, 2)[data["function"] - 1]

    def test_values_and_expected_running_times_agree(self, coco_read):
        results, found = coco_read
        references, reached = coco.references(results), 0
        for data in found["sets"]:
            problem, runs = self.traces(results, data)
            reference = references[problem].value
            finals = [min(max(row.fun - reference, 1e-12), 3e21) for _, row in runs]
            np.testing.assert_allclose(data["finals"], finals, rtol=1e-9)
            for target, ert in zip(TARGETS, data["ert"], strict=True):
                hits = [trace.evaluations[trace.values - reference <= target] for trace, _ in runs]
                spent = sum(hit[0] if len(hit) else row.nfev for hit, (_, row) in zip(hits, runs, strict=True))
                successes = sum(len(hit) > 0 for hit in hits)
                assert ert == pytest.approx(spent / successes if successes else math.inf)
                reached += successes
        assert reached > 100

    def test_values_at_the_triggered_evaluations_agree(self, coco_read):
        results, found = coco_read
        references, compared = coco.references(results), 0
        for data in found["sets"]:
            problem, runs = self.traces(results, data)
            evaluations, *columns = np.array(data["funvals"]).T
            for (trace, row), column in zip(runs, columns, strict=True):
                triggered = np.isin(evaluations, [*TRIGGERS, row.nfev]) & (evaluations <= row.nfev)
                expected = np.clip(trace.at(evaluations) - references[problem].value, 1e-12, 3e21)
                np.testing.assert_allclose(column[triggered], expected[triggered], rtol=1e-9)
                compared += triggered.sum()
        assert compared > 1000

    def test_the_suite_has_as_many_functions_as_cocopp_knows(self, coco_read):
        assert coco_read[1]["last"] == coco.FUNCTIONS


class TestCOCOFiles:
    def test_a_known_optimum_is_the_reference_unless_a_trial_is_below_it(self, tmp_path):
        below = make(tmp_path / "b", row=lambda trial, values: record([3.0, -1.0], 2) if trial.number == 0 else None)
        above = make(tmp_path / "a")
        lowest = above.frame.groupby("problem")["fun"].min().to_dict()
        assert coco.references(above)["sphere-2"] == coco.Reference(0.0, "the problem's best known value")
        assert coco.references(above)["p"] == coco.Reference(lowest["p"], "the lowest value found by any trial")
        assert coco.references(below)["sphere-2"].value == -1.0
        readme = (export(above, "coco", tmp_path / "out").folder / "README.txt").read_text()
        assert "1  sphere-2: 0.0, the problem's best known value" in readme
        assert f"2  p: {lowest['p']!r}, the lowest value found by any trial" in readme

    def test_the_best_value_of_all_is_written_as_a_positive_difference(self, tmp_path):
        results = make(tmp_path / "s", {"p": 2}, row=lambda trial, values: record([1e10 + 1, 1e10], 2))
        folder = export(results, "coco", tmp_path / "out").folder
        paths = sorted(folder.rglob("*dat"))
        assert len(paths) == 4
        for path in paths:
            rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("%")]
            assert {row[2] for row in rows} == {"+1.000000000e+00", "+1.000000000e-12"}

    def test_evaluations_are_triggered_twenty_times_a_decade(self, tmp_path):
        values = np.linspace(2, 1, 1234)
        results = make(tmp_path / "s", trials=1, row=lambda *_: record(values.tolist(), 2))
        folder = export(results, "coco", tmp_path / "out").folder
        lines = (folder / "a" / "data_f2" / "bbobexp_f2_DIM2.tdat").read_text().splitlines()[1:]
        expected = [*TRIGGERS, 1234]
        assert [int(line.split()[0]) for line in lines] == expected

    def test_more_problems_than_functions_are_refused(self, tmp_path):
        problems = {f"p{i}": 1 for i in range(55)}
        results = make(tmp_path / "s", problems, ("a",), trials=1)
        with pytest.raises(BenchError, match="at most 54 problems and this study has 55"):
            export(results, "coco", tmp_path / "out")
        assert not (tmp_path / "out").exists()
