"""The ioh format, read back with the real iohinspector in a process of its own."""

import json
import math
from importlib.util import find_spec

import pytest

from bench import BenchError, analysis
from bench.formats.exporting import export
from bench.formats.ioh import writer as ioh
from tests.bench.formats.ioh.test_reader import logged
from tests.bench.formats.made import BUDGET, HOSTILE, exported, make, read, some_fail

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


@pytest.fixture(scope="module")
def ioh_read(tmp_path_factory):
    place = tmp_path_factory.mktemp("ioh")
    results = make(place / "s", {"sphere-2": 2, "../../p": 3, "never": 2}, (*HOSTILE, "a"), row=some_fail)
    folder = exported(results, "ioh", place / "out")
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
        folder = exported(results, "ioh", tmp_path / "out")
        head = json.loads(next(folder.glob("a/*.json")).read_text())
        assert head["experiment_attributes"] == [{"git_sha": "0a1+0a1-dirty"}]


@pytest.mark.skipif(find_spec("iohinspector") is None, reason="reads the ioh format with iohinspector")
def test_a_suite_keeps_its_functions_and_instances_and_lies_beside_ioh_s_own_data(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    labels = {f"bbob-f{f:02d}-d{d}-i{i}": d for f in (2, 8) for d in (2, 5) for i in (1, 4)}
    results = make(tmp_path / "s", labels, trials=2)
    folder = exported(results, "ioh", tmp_path / "out")
    run = {"instance": 4, "evals": 1, "best": {"evals": 1, "y": 9.0, "x": [0.0] * 5}}
    logged(folder / "theirs", "evaluations raw_y\n1 9.0\n", [run])
    found = read(READ_IOH, folder, tmp_path)["overview"]
    assert {(row["suite"], row["function_id"], row["function_name"]) for row in found} == {
        ("BBOB", 2, "Ellipsoid"), ("BBOB", 8, "Rosenbrock"), ("BBOB", 6, "AttractiveSector")
    }  # fmt: skip
    own = [row for row in found if row["algorithm_name"] == "a" and row["function_id"] == 8 and row["dimension"] == 5]
    assert [row["instance"] for row in own] == [1, 1, 4, 4]
    optima = {i: results.facts(f"bbob-f08-d5-i{i}").optimum for i in (1, 4)}
    frame = results.frame[results.frame["optimizer"] == "a"].set_index("problem")["fun"]
    expected = [value - optima[i] for i in (1, 4) for value in frame[f"bbob-f08-d5-i{i}"]]
    assert [row["best_y"] for row in own] == expected


def test_several_suites_have_a_folder_each(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    results = make(tmp_path / "s", {"bbob-f01-d2-i1": 2, "classical-sphere-d2-i1": 2, "p": 3}, ("a",))
    folder = exported(results, "ioh", tmp_path / "out")
    assert sorted(str(path.relative_to(folder)) for path in folder.rglob("*.json")) == [
        "bbob/a/IOHprofiler_f1_sphere.json",
        "classical/a/IOHprofiler_f1_sphere.json",
        "other-problems/a/IOHprofiler_f3_p.json",
    ]


READ_AOCC = """
import iohinspector
from iohinspector.metrics.utils import transform_fval
import polars
manager = iohinspector.DataManager()
manager.add_folder(sys.argv[1])
rows = manager.load(monotonic=True, include_meta_data=True)
shares = transform_fval(rows, lb=1e-8, ub=1e2)
found = iohinspector.metrics.get_aocc(shares, eval_max=int(sys.argv[3]))
print("\\n" + found.to_json(orient="records"))
"""


@pytest.mark.slow
@pytest.mark.skipif(find_spec("iohinspector") is None, reason="compares with iohinspector")
def test_the_area_over_the_convergence_curve_is_iohinspector_s(tmp_path):
    results = make(tmp_path / "s", {"sphere-2": 2, "p": 3})
    found = read(READ_AOCC, exported(results, "ioh", tmp_path / "out"), tmp_path, str(BUDGET))
    theirs = {(row["function_name"], row["algorithm_name"]): row["AOCC"] for row in found}
    own = analysis.aocc(results.frame, results.traces, {"sphere-2": 0.0, "p": 0.0}, BUDGET)
    assert len(own) == len(theirs) == 4
    for row in own.itertuples():
        assert row.aocc_from_zero == pytest.approx(theirs[row.problem, row.optimizer], rel=1e-9)
        assert row.aocc == pytest.approx(row.aocc_from_zero, abs=1 / BUDGET)


def test_more_problems_than_the_ioh_format_numbers_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(ioh, "LARGEST", 1)
    with pytest.raises(BenchError, match="at most 1 problems"):
        export(make(tmp_path / "s", trials=1), "ioh", tmp_path / "out")
    assert not (tmp_path / "out").exists()
