"""IOHprofiler's data: round trips of our own export, BBOB as IOHexperimenter logs it, and files that are refused."""

import json

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from bench import BenchError, Results, load_problem
from bench.cli.app import app
from bench.formats.importing import import_results
from bench.topics.findings import Findings
from bench.topics.trust.section import section
from tests.bench.formats.made import exported, make


def test_problems_of_suites_come_back_with_their_names(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    labels = {"bbob-f08-d2-i3": 2, "bbob-f08-d2-i1": 2, "bbob-f08-d5-i1": 5, "classical-sphere-d2-i2": 2, "p": 3}
    results = make(tmp_path / "s", labels)
    import_results(exported(results, "ioh", tmp_path / "out"), tmp_path / "back")
    back, keys = Results(tmp_path / "back").frame, ["problem", "optimizer", "trial"]
    theirs, own = (each.astype({"problem": str}).sort_values(keys) for each in (back, results.frame))
    for name in (*keys, "seed", "nfev"):
        assert theirs[name].tolist() == own[name].tolist()
    np.testing.assert_allclose(theirs["fun"], own["fun"], rtol=1e-12, atol=1e-13)


def test_our_export_comes_back_to_the_last_bit(tmp_path):
    results = make(tmp_path / "s", {"sphere-2": 2, "p": 3})
    import_results(exported(results, "ioh", tmp_path / "out"), tmp_path / "back")
    back = Results(tmp_path / "back")
    names = ["problem", "optimizer", "trial", "seed", "fun", "nfev"]
    pd.testing.assert_frame_equal(back.frame[names], results.frame[names], check_dtype=False, check_exact=True)
    assert back.frame[["x_x1", "x_x2"]].to_numpy().tolist() == results.frame[["x_x0", "x_x1"]].to_numpy().tolist()
    for key, trace in results.traces.items():
        assert back.traces[key].evaluations.tolist() == trace.evaluations.tolist()
        assert back.traces[key].values.tolist() == trace.values.tolist()


HEAD = {
    "version": "0.3.22", "suite": "BBOB", "function_id": 6, "function_name": "AttractiveSector", "maximization": False,
    "algorithm": {"name": "rs", "info": ""}, "attributes": ["evaluations", "raw_y"],
}  # fmt: skip
RUNS = [
    {"instance": 1, "evals": 50, "best": {"evals": 43, "y": 5784.815836694389, "x": [1.0, 2.0, 3.0, 4.0, 5.0]}},
    {"instance": 2, "evals": 9, "best": {"evals": 4, "y": 7.25, "x": [0.0, 0.0, 0.0, 0.0, 0.0]}},
]
LOG = """evaluations raw_y
1 582226.1784963573
43 5784.8158366944
50 556778.5524187874
evaluations raw_y
1 8.0
4 7.25
"""


def logged(folder, log=LOG, runs=RUNS, **changes):
    """Write a folder as IOHexperimenter does."""
    path = "data_f6_AttractiveSector/IOHprofiler_f6_DIM5.dat"
    head = HEAD | {"scenarios": [{"dimension": 5, "path": path, "runs": runs}]} | changes
    (folder / path).parent.mkdir(parents=True)
    (folder / path).write_text(log)
    (folder / "IOHprofiler_f6_AttractiveSector.json").write_text(json.dumps(head))
    return folder


def test_bbob_gets_this_project_s_names_and_objective_values(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    import_results(logged(tmp_path / "x"), tmp_path / "back")
    results = Results(tmp_path / "back")
    assert results.frame["problem"].tolist() == ["bbob-f06-d5-i1", "bbob-f06-d5-i2"]
    assert results.frame["nfev"].tolist() == [50, 9]
    optima = np.array([results.facts(label).optimum for label in results.frame["problem"]])
    best = np.array([5784.815836694389, 7.25])  # with all digits of the JSON file
    assert results.frame["fun"].tolist() == (optima + best).tolist()
    assert results.traces["bbob-f06-d5-i1", "rs", 0].evaluations.tolist() == [1, 43]


POINT = [-2.7701787547621093, -0.8239530205145273, 0.6430778994240107, 2.6990302090039258, 2.0396877373660605]
VALUES = {"bbob": 1375.7603702038753, "sbox-cost": 2875.155849696214}
"""What ioh 0.3.22 logs at this point of Rosenbrock's function, instance 1, of the two suites, without their names."""


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("suite", VALUES)
def test_a_suite_with_the_names_of_bbob_s_functions_is_known_by_its_values(tmp_path, suite, named):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    value = VALUES[suite]
    given = {"bbob": "BBOB", "sbox-cost": "SBOX"}[suite] if named else "unknown_suite"
    run = {"instance": 1, "evals": 38, "best": {"evals": 38, "y": value, "x": POINT}}
    folder = logged(
        tmp_path / "x", f"evaluations raw_y\n38 {value:.10f}\n", [run],
        suite=given, function_id=8, function_name="Rosenbrock",
    )  # fmt: skip
    notes = import_results(folder, tmp_path / "back").notes
    frame = Results(tmp_path / "back").frame
    assert frame["problem"].tolist() == [f"{suite}-f08-d5-i1"]
    assert frame["fun"].tolist() == [149.15 + value]
    unnamed = f"The logs name no suite; functions with the numbers and names of bbob's are taken for those of {suite}."
    assert notes == (() if named else (unnamed,))


def test_the_optimum_of_a_bbob_function_is_the_same_in_dimensions_that_coco_does_not_have(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    path = "data_f6_AttractiveSector/IOHprofiler_f6_DIM5.dat"
    import_results(logged(tmp_path / "x", scenarios=[{"dimension": 7, "path": path, "runs": RUNS}]), tmp_path / "back")
    frame = Results(tmp_path / "back").frame
    assert frame["problem"].tolist() == ["bbob-f06-d7-i1", "bbob-f06-d7-i2"]
    assert frame["fun"][1] == 7.25 + load_problem("bbob-f06-d2-i2").optimum


def test_another_suite_keeps_its_name_and_its_values(tmp_path):
    import_results(logged(tmp_path / "x", suite="My Suite"), tmp_path / "back")
    results = Results(tmp_path / "back")
    assert results.frame["problem"].tolist() == ["my-suite-f06-d5-i1", "my-suite-f06-d5-i2"]
    assert results.frame["fun"].tolist() == [5784.815836694389, 7.25]
    assert "known from imported results only" in results.facts("my-suite-f06-d5-i1").reason


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"maximization": True}, "holds results of maximisation"),
        ({"scenarios": [{"dimension": 5, "path": "../../etc/passwd", "runs": []}]}, "which is outside the folder"),
        ({"scenarios": [{"dimension": 5, "path": "no.dat", "runs": []}]}, "the log no.dat is missing"),
        ({"algorithm": {}}, "it lacks 'name'"),
        ({"log": LOG[:-5]}, "is cut short in line 7"),
        ({"log": LOG[: LOG.index("evaluations", 5)]}, "has 1 runs and .* names 2"),
        ({"log": LOG.replace("4 7.25\n", "")}, "run 2, ends at 8.0 and its JSON file has 7.25; the log is cut short"),
        ({"log": LOG.replace("43", "51")}, "line 4, has evaluation 50 after evaluation 51"),
        ({"log": LOG.replace("4 7.25", "1 7.25")}, "line 7, has evaluation 1 after evaluation 1"),
        ({"log": LOG.replace("4 7.25", f"{10**30} 7.25")}, "line 7, is no row of evaluations and values"),
        ({"function_id": 1e999}, "has a value of another kind .cannot convert float infinity to integer"),
        (
            {"runs": [RUNS[0] | {"evals": 10**30}, RUNS[1]]},
            "nfev 10{30}, which must be from 0 to 10{15}",
        ),
        ({"log": LOG.replace("4 7.25", "4 abc")}, "line 7, is no row of evaluations and values: '4 abc'"),
        ({"log": LOG.replace("raw_y", "other")}, "line 1, has no column 'raw_y'"),
    ],
)
def test_what_is_broken_is_named_and_nothing_is_imported(tmp_path, changes, sentence):
    with pytest.raises(BenchError, match=sentence):
        import_results(logged(tmp_path / "x", **changes), tmp_path / "back")
    assert [each.name for each in tmp_path.iterdir()] == ["x"]


def test_a_log_of_maximisation_is_left_out_by_name_where_that_is_asked_for(tmp_path):
    logged(tmp_path / "x" / "a", suite="Own")
    logged(tmp_path / "x" / "b", suite="Own", function_id=7, maximization=True)
    out = tmp_path / "back"
    refused = CliRunner().invoke(app, ["import", str(tmp_path / "x"), "-o", str(out)])
    assert isinstance(refused.exception, BenchError)
    assert not out.exists()
    found = CliRunner().invoke(app, ["import", str(tmp_path / "x"), "-o", str(out), "--partial"])
    sentence = "b/IOHprofiler_f6_AttractiveSector.json holds results of maximisation"
    assert f"left out: {sentence}" in " ".join(found.output.split())
    assert Results(out).frame["problem"].tolist() == ["own-f06-d5-i1", "own-f06-d5-i2"]
    assert sentence in " ".join(CliRunner().invoke(app, ["status", str(out)]).output.split())
    assert any(sentence in line.text for line in section(Findings(Results(out))).lines)
