"""Biases: each is found in an optimizer that was made to have it, and one that has none is cleared of all."""

from functools import cache

import numpy as np
import pytest

from bench import BenchError, load_optimizer
from bench.check import bias
from bench.check.bias import LIMIT, centre_bias, diagnose, starts_and_seeds, structural_bias
from bench.check.runs import BOXES, Runs, RunSummary
from bench.sandbox.callers import Callers
from tests.bench.check.biased import (
    Central,
    Chains,
    Clipping,
    Constant,
    Cornered,
    Deterministic,
    Guessing,
    Numbered,
    Raising,
    Shrinking,
)

pytestmark = pytest.mark.usefixtures("little_work", "in_this_process")

CHECKS = ["centre bias", "structural bias", "boundary clamping", "starts and seeds"]
SMALL = {"dimension": 3, "runs": 2, "noise_runs": 40, "n_jobs": 1}


@cache
def found(optimizer):
    return {verdict.check: verdict for verdict in diagnose(optimizer, **SMALL)}


def unbiased(seed, n=60, d=3):
    """Return runs whose final points and starts are uniform and independent."""
    rng = np.random.default_rng(seed)
    runs = {box: [RunSummary(0.0, rng.random(d), rng.random((1, d)), 0.0, "") for _ in range(n)] for box in BOXES}
    return Runs({}, {}, runs)


def test_a_method_without_bias_passes_every_check():
    verdicts = found(Chains())
    assert list(verdicts) == CHECKS
    assert [check for check, verdict in verdicts.items() if not verdict.passed] == []
    assert {verdict.remedy for verdict in verdicts.values()} == {""}
    assert {verdict.kind for verdict in verdicts.values()} == {"bias"}
    assert 1 / LIMIT < verdicts["centre bias"].figure < LIMIT


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("optimizer", "check", "seen", "remedy"),
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
def test_a_method_with_a_bias_is_found_out(optimizer, check, seen, remedy):
    verdict = found(optimizer)[check]
    assert not verdict.passed
    assert seen in verdict.finding
    assert remedy in verdict.remedy


@pytest.mark.slow
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


@pytest.mark.slow
def test_random_search_passes_every_check():
    assert all(verdict.passed for verdict in diagnose(load_optimizer("random-search"), runs=5, n_jobs=1))


def test_gwo_is_biased():
    gwo = load_optimizer("gwo", agents=30)
    verdicts = diagnose(gwo, runs=2, noise_runs=40, n_jobs=1)
    assert [verdict.check for verdict in verdicts if not verdict.passed] == CHECKS[:3]


@pytest.mark.slow
def test_the_seed_alone_repeats_the_figures_whatever_the_number_of_processes(monkeypatch):
    gwo, sizes = load_optimizer("gwo", agents=30), {"runs": 1, "noise_runs": 5}
    first = diagnose(gwo, n_jobs=1, **sizes)
    with monkeypatch.context() as patch:
        patch.setattr("bench.check.runs.Callers", Callers)
        assert diagnose(gwo, n_jobs=2, **sizes) == first
    assert diagnose(gwo, n_jobs=1, seed=1, **sizes)[:2] != first[:2]


def test_an_unbiased_method_is_hardly_ever_accused():
    passed = [structural_bias(runs).passed and starts_and_seeds(runs).passed for runs in map(unbiased, range(60))]
    assert sum(passed) >= 57  # 59.3 expected


def test_a_run_without_a_finite_value_counts_as_the_worst():
    def runs(*best):
        return {"sphere": [RunSummary(each, np.zeros(1), np.zeros((1, 1)), 0.0, "") for each in best]}

    assert centre_bias(Runs(runs(1.0, 2.0), runs(np.inf, 2.0), {})).figure > 1e100
    assert centre_bias(Runs(runs(np.inf, 0.0), runs(np.inf, 2e-9), {})).figure == pytest.approx(1.0)


@pytest.mark.slow
def test_a_failing_optimizer_is_named_with_its_error():
    with pytest.raises(BenchError, match="failed on sphere: ZeroDivisionError: boom"):
        diagnose(Raising(), n_jobs=1)


def test_every_check_has_its_place_in_the_report():
    from bench.analysis.integrity import TRAITS

    assert list(TRAITS) == CHECKS
    assert len(bias.CHECKS) == len(CHECKS)
