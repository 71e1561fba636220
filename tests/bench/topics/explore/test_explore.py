import json

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Results, analysis
from bench.topics.explore import explore as module
from bench.topics.explore.explore import explore
from bench.topics.findings import Findings


@pytest.fixture(scope="module")
def data(findings):
    return json.loads(json.dumps(explore(findings), allow_nan=False))


def cell(data, problem, optimizer):
    return next(each for each in data["cells"] if (each["problem"], each["optimizer"]) == (problem, optimizer))


def test_every_run_is_there_with_its_seed_value_and_reason_to_stop(data, findings):
    assert data["complete"]
    assert len(data["cells"]) == 6
    frame = findings.trials.frame[
        (findings.trials.frame["problem"] == "p") & (findings.trials.frame["optimizer"] == "a")
    ]
    own = cell(data, 0, 0)
    assert own["seed"] == [str(each) for each in frame["seed"]]
    assert own["fun"] == pytest.approx(frame["fun"].tolist(), rel=1e-6)
    assert (own["nfev"], data["texts"][own["stop"]]) == (100, "budget")
    assert [float(each) for each in own["x"]] == pytest.approx(frame["x_x1"].tolist(), rel=1e-6)


def test_a_failed_run_has_no_value_and_its_first_line_of_error(data):
    own = cell(data, 0, 1)
    assert (own["trials"], own["failed"], own["fun"][1], own["curve"][1]) == (4, 1, None, "i")
    assert [reason and data["texts"][reason] for reason in own["error"]] == [
        None, "failed: ValueError: <b>boom</b> & more", None, None,
    ]  # fmt: skip


def test_a_curve_is_the_trace_above_the_reference(data, findings, decoded):
    grid = np.array(data["grid"])
    curve = decoded(cell(data, 0, 2)["curve"][0], len(grid))
    trace = findings.trials.traces["p", "<i>c", 0]
    values = data["problems"][0]["reference"] + curve
    assert values == pytest.approx(trace.at(grid), rel=1e-3)


def test_the_options_make_a_command_and_problems_have_their_features(data):
    assert [each["label"] for each in data["optimizers"]] == ["a", "b", "<i>c"]
    assert data["optimizers"][0]["command"] == "any"
    assert data["problems"][0]["features"] == {"dimension": 1}
    assert data["problems"][0]["budget"] == data["grid"][-1] == 100


def test_the_data_of_a_problem_are_there_with_the_model_of_a_fit(data):
    shown = data["problems"][0]["data"]
    assert shown["model"] == "point.x1 * datum.t"
    assert shown["t"] == pytest.approx([0.0, 1 / 49])
    assert (shown["samples"], shown["values"]["high"]) == (50, 0.5)


@pytest.mark.parametrize("error", [BenchError("not installed"), ZeroDivisionError()])
def test_a_problem_that_cannot_be_loaded_or_fails_has_no_data(study, monkeypatch, error):
    def fail(*_):
        raise error

    of = (Results, "problem") if isinstance(error, BenchError) else (FunctionProblem, "fitted_data")
    monkeypatch.setattr(Results, "problem", lambda self, label: FunctionProblem(len, [0.0], [1.0]))
    monkeypatch.setattr(*of, fail)
    data = explore(Findings(Results(study)))
    assert [each["data"] for each in data["problems"]] == [None, None]


def test_a_larger_study_keeps_quartiles_of_all_runs_and_the_first_runs(study, monkeypatch, decoded):
    findings = Findings(Results(study))
    monkeypatch.setattr(module, "MOST_RUNS", 13)
    data = explore(findings)
    assert not data["complete"]
    assert "The study has 24 runs, more than the 13 that fit into a page" in data["notes"][0]
    assert "the first 2 runs of each cell" in data["notes"][0]
    own = cell(data, 0, 1)  # one of its four trials failed
    assert (own["trials"], len(own["fun"]), len(own["curve"])) == (4, 2, 2)
    grid = np.array(data["grid"])
    curves = analysis.convergence(findings.trials.frame, findings.trials.traces, grid)
    curves = curves[(curves["problem"] == "p") & (curves["optimizer"] == "b")]
    reference = data["problems"][0]["reference"]
    for text, name in zip(own["quartiles"], ("q1", "median", "q3"), strict=True):
        assert reference + decoded(text, len(grid)) == pytest.approx(curves[name].to_numpy(), rel=1e-3)


def test_the_largest_study_has_no_runs_and_beyond_it_there_is_nothing(study, monkeypatch):
    monkeypatch.setattr(module, "MOST_RUNS", 5)
    data = explore(Findings(Results(study)))
    assert "no single runs" in data["notes"][0]
    assert "curve" not in data["cells"][0]
    monkeypatch.setattr(module, "MOST_CELLS", 5)
    assert explore(Findings(Results(study))) is None


def test_best_points_are_left_out_where_they_are_too_many(study, monkeypatch):
    monkeypatch.setattr(module, "MOST_COORDINATES", 23)
    data = explore(Findings(Results(study)))
    assert "x" not in data["cells"][0]
    assert "The runs’ best points are left out" in data["notes"][0]
