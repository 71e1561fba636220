"""Biases: each is found in an optimizer that was made to have it, and one that has none is cleared of all."""

import json
from dataclasses import asdict
from functools import cache, partial

import cloudpickle
import numpy as np
import pytest
from joblib import parallel_config

from bench import BenchError, Results, Study, load_optimizer, run
from bench.check import bias
from bench.check.bias import (
    BOXES,
    LIMIT,
    Runs,
    RunSummary,
    centre_bias,
    diagnose,
    diagnose_folder,
    make_runs,
    starts_and_seeds,
    structural_bias,
)
from bench.check.problems import FUNCTIONS
from bench.check.verdict import Verdict
from bench.storage.folder import Folder
from tests.bench.check import biased
from tests.bench.check.biased import (
    Central,
    Chains,
    Clipping,
    Constant,
    Cornered,
    Deterministic,
    Exiting,
    Guessing,
    Numbered,
    Raising,
    Shrinking,
)


@pytest.fixture(autouse=True)
def little_work(monkeypatch):
    """Leave one of the functions, and short runs on it; a worker process of this test's would not know of it."""
    monkeypatch.setattr("bench.check.bias.FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    monkeypatch.setattr("bench.check.bias.FUNCTION_BUDGET", 2_000)


CHECKS = ["centre bias", "structural bias", "boundary clamping", "starts and seeds"]
SMALL = {"dimension": 3, "runs": 2, "noise_runs": 40, "n_jobs": 1}


@cache
def found(optimizer):
    return {verdict.check: verdict for verdict in diagnose(optimizer, **SMALL)}


def unbiased(seed, n=60, d=3):
    """Return runs whose final points and starts are uniform and independent."""
    rng = np.random.default_rng(seed)
    runs = {box: [RunSummary(0.0, rng.random(d), rng.random((1, d)), 0.0, b"") for _ in range(n)] for box in BOXES}
    return Runs({}, {}, runs)


def test_a_method_without_bias_passes_every_check():
    verdicts = found(Chains())
    assert list(verdicts) == CHECKS
    assert [check for check, verdict in verdicts.items() if not verdict.passed] == []
    assert {verdict.mend for verdict in verdicts.values()} == {""}
    assert {verdict.kind for verdict in verdicts.values()} == {"bias"}
    assert 1 / LIMIT < verdicts["centre bias"].figure < LIMIT


@pytest.mark.parametrize(
    ("optimizer", "check", "seen", "mend"),
    [
        (Shrinking(), "centre bias", "above the limit of 10", "moves that shrink"),
        (Shrinking(), "structural bias", "are not uniform", "drawn to the centre"),
        (Clipping(), "boundary clamping", "above the limit of 1%", "reflect"),
        (Cornered(), "starts and seeds", "80 seeds are not uniform in the box", "objective.initial"),
        (Numbered(), "starts and seeds", "depend on the starts of adjacent seeds", "objective.initial"),
        (Constant(), "starts and seeds", "80 runs with different seeds have only 1 different first", "from the rng"),
        (Deterministic(), "starts and seeds", "2 of 4 runs on functions repeat another", "make one trial"),
    ],
)
def test_a_method_with_a_bias_is_found_out(optimizer, check, seen, mend):
    verdict = found(optimizer)[check]
    assert not verdict.passed
    assert seen in verdict.finding
    assert mend in verdict.mend


@pytest.mark.parametrize(
    ("optimizer", "biases"),
    [
        (Shrinking(), {"centre bias", "structural bias"}), (Cornered(), {"structural bias", "starts and seeds"}),
        (Constant(), {"starts and seeds"}), (Deterministic(), {"starts and seeds"}),
    ],
)  # fmt: skip
def test_a_bias_is_not_taken_for_another(optimizer, biases):
    failed = {check for check, verdict in found(optimizer).items() if not verdict.passed}
    assert failed & set(CHECKS) == biases


def test_one_start_for_all_runs_is_told_and_is_no_fault():
    verdict = found(Central())["starts and seeds"]
    assert verdict.passed
    assert verdict.figure is None
    assert "every run starts at the same point" in verdict.finding


def test_a_method_that_does_better_off_the_centre_is_told_so():
    verdict = found(Guessing())["centre bias"]
    assert verdict.passed
    assert verdict.figure < 1 / LIMIT
    assert "better away from the centre" in verdict.finding


def test_random_search_passes_every_check():
    assert all(verdict.passed for verdict in diagnose(load_optimizer("random-search"), runs=5, n_jobs=1))


def test_gwo_is_biased():
    gwo = load_optimizer("gwo", agents=30)
    verdicts = diagnose(gwo, runs=2, noise_runs=40, n_jobs=1)
    assert [verdict.check for verdict in verdicts if not verdict.passed] == CHECKS[:3]


def test_the_seed_alone_repeats_the_figures():
    gwo, sizes = load_optimizer("gwo", agents=30), {"runs": 1, "noise_runs": 5}
    first = diagnose(gwo, n_jobs=1, **sizes)
    with parallel_config("threading"):  # another process would not know the one function
        assert diagnose(gwo, n_jobs=2, **sizes) == first
    assert diagnose(gwo, n_jobs=1, seed=1, **sizes)[:2] != first[:2]


def test_an_unbiased_method_is_hardly_ever_accused():
    passed = [structural_bias(runs).passed and starts_and_seeds(runs).passed for runs in map(unbiased, range(60))]
    assert sum(passed) >= 57  # 59.3 expected


def test_a_run_without_a_finite_value_counts_as_the_worst():
    def runs(*best):
        return {"sphere": [RunSummary(each, np.zeros(1), np.zeros((1, 1)), 0.0, b"") for each in best]}

    assert centre_bias(Runs(runs(1.0, 2.0), runs(np.inf, 2.0), {})).figure > 1e100
    assert centre_bias(Runs(runs(np.inf, 0.0), runs(np.inf, 2e-9), {})).figure == pytest.approx(1.0)


def test_a_failing_optimizer_is_named_with_its_error():
    with pytest.raises(BenchError, match="failed on sphere: ZeroDivisionError: boom"):
        diagnose(Raising(), n_jobs=1)


def test_an_optimizer_that_ends_its_process_is_told_in_a_sentence():
    cloudpickle.register_pickle_by_value(biased)  # workers cannot import this module
    try:
        with pytest.raises(BenchError, match="ended its worker process"):
            diagnose(Exiting(), n_jobs=2)
    finally:
        cloudpickle.unregister_pickle_by_value(biased)


def test_every_check_has_its_place_in_the_report():
    from bench.analysis.integrity import TRAITS

    assert list(TRAITS) == CHECKS
    assert len(bias.CHECKS) == len(CHECKS)


def test_runs_are_kept_as_shares_of_their_box():
    made = make_runs(Clipping(), dimension=2, runs=1, noise_runs=3)
    assert [len(those) for those in made.noise.values()] == [3, 3]
    for each in (*made.noise["[-1, 1]"], *made.centred["sphere"]):
        assert each.first.shape == (20, 2)
        assert 0.2 < each.first.mean() < 0.8
        assert ((each.x >= 0) & (each.x <= 1)).all()
    assert made.centred["sphere"][0].x == pytest.approx(0.5, abs=1e-3)
    assert made.moved["sphere"][0].x == pytest.approx(0.6, abs=1e-3)
    assert all(0 < run.clamped < 0.5 for run in made.noise["[0, 1]"])


def test_a_run_is_the_same_among_fewer_others():
    many, few = (make_runs(Chains(), dimension=2, runs=runs, noise_runs=runs) for runs in (2, 1))
    assert [run.course for run in few.moved["sphere"]] == [run.course for run in many.moved["sphere"][:1]]
    for box in BOXES:
        assert [run.course for run in few.noise[box]] == [run.course for run in many.noise[box][:1]]


def test_the_first_generation_has_the_size_of_the_population():
    climber = make_runs(load_optimizer("hill-climber"), dimension=2, runs=1, noise_runs=2)
    large = make_runs(Chains(agents=100), dimension=2, runs=1, noise_runs=2)
    assert climber.noise["[0, 1]"][0].first.shape == (1, 2)
    assert large.noise["[0, 1]"][0].first.shape == (100, 2)


@pytest.fixture
def few_runs(monkeypatch):
    monkeypatch.setattr("bench.check.bias.diagnose", partial(diagnose, dimension=2, runs=1, noise_runs=3))


def test_a_folder_keeps_the_verdicts_on_its_optimizers(tmp_path, few_runs):
    entries = [{"name": "scatter", "agents": 7}, {"name": "early"}]
    study = {"name": "s", "trials": 1, "budget": 40, "problems": [{"name": "sphere-3"}], "optimizers": entries}
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1)
    assert Results(tmp_path / "out").checks == {}
    found, failed = diagnose_folder(Folder(tmp_path / "out"), n_jobs=1)
    assert failed == {}
    assert list(found) == ["scatter", "early"]
    assert found["scatter"] == diagnose(
        Study.from_dict(study).optimizer("scatter"), n_jobs=1, dimension=2, runs=1, noise_runs=3
    )
    assert Results(tmp_path / "out").checks == {
        label: [asdict(each) for each in those] for label, those in found.items()
    }


def test_notes_of_older_versions_are_read_and_what_is_no_verdict_is_passed_over(tmp_path, small_study):
    run(small_study.override(trials=1), tmp_path / "out", n_jobs=1)
    old = {"check": "centre bias", "passed": False, "figure": 50.0, "finding": "worse off the centre"}
    new = Verdict("starts and seeds", "bias", True, "every run starts at the same point").as_dict()
    notes = {
        "scatter": [old, new, old | {"check": 3}, old | {"passed": "no"}, old | {"figure": "50"}, {}],
        "early": 5,
        "hill-climber": [old, 5],
        "stranger": [old],
    }
    (tmp_path / "out" / "checks.json").write_text(json.dumps(notes))
    assert Results(tmp_path / "out").checks == {"scatter": [old | {"kind": "bias", "mend": ""}, new]}


def test_an_optimizer_that_fails_costs_the_others_nothing(tmp_path, few_runs):
    entries = [{"name": "faulty"}, {"name": "scatter"}]
    study = {"name": "s", "trials": 1, "budget": 40, "problems": [{"name": "sphere-3"}], "optimizers": entries}
    run(Study.from_dict(study), tmp_path / "out", n_jobs=1)  # 'faulty' raises in two dimensions
    found, failed = diagnose_folder(Folder(tmp_path / "out"), n_jobs=1)
    assert list(found) == list(Results(tmp_path / "out").checks) == ["scatter"]
    assert failed == {"faulty": "the optimizer failed on sphere: RuntimeError: cannot do planes"}
