"""Biases: each is found in an optimizer that was made to have it, and one that has none is cleared of all."""

from functools import cache

import pytest

from bench import BenchError, load_optimizer
from bench.check.bias import LIMIT, diagnose
from tests.bench.check.biased import (
    LITTLE,
    SHORT,
    Chains,
    Clipping,
    Constant,
    Cornered,
    Deterministic,
    Numbered,
    Raising,
    Shrinking,
)

CHECKS = ["centre bias", "structural bias", "boundary clamping", "starts and seeds"]
SMALL = LITTLE | {"dimension": 3, "runs": 2, "noise_runs": 40}


@cache
def found(optimizer):
    return {verdict.check: verdict for verdict in diagnose(optimizer, **SMALL)}


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


@pytest.mark.slow
def test_random_search_passes_every_check():
    assert all(verdict.passed for verdict in diagnose(load_optimizer("random-search"), **LITTLE, runs=5))


def test_gwo_is_biased():
    gwo = load_optimizer("gwo", agents=30)
    verdicts = diagnose(gwo, **LITTLE, runs=2, noise_runs=40)
    assert [verdict.check for verdict in verdicts if not verdict.passed] == CHECKS[:3]


@pytest.mark.slow
def test_the_seed_alone_repeats_the_figures_whatever_the_number_of_processes():
    gwo, sizes = load_optimizer("gwo", agents=30), {"runs": 1, "noise_runs": 5}
    first = diagnose(gwo, **LITTLE, **sizes)
    assert diagnose(gwo, n_jobs=2, **SHORT, **sizes) == first
    assert diagnose(gwo, seed=1, **LITTLE, **sizes)[:2] != first[:2]


@pytest.mark.slow
def test_a_failing_optimizer_is_named_with_its_error():
    with pytest.raises(BenchError, match="failed on sphere: ZeroDivisionError: boom"):
        diagnose(Raising(), **LITTLE)
