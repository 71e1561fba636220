"""Biases: each is found in an optimizer that was made to have it, and one that has none is cleared of all."""

import os
import sys
from dataclasses import dataclass
from functools import cache

import cloudpickle
import numpy as np
import pytest
from joblib import parallel_config

from bench import BenchError, Optimizer, load_optimizer, parameter
from bench.check.bias import diagnosis
from bench.check.bias.diagnosis import FLOOR, LIMIT, centre_bias, diagnose, starts_and_seeds, structural_bias
from bench.check.bias.functions import FUNCTIONS, HALF_WIDTH, SHIFT, function, noise
from bench.check.bias.runs import BOXES, Runs, RunSummary, make_runs

CHECKS = ["centre bias", "structural bias", "boundary clamping", "starts and seeds"]
SMALL = {"dimension": 3, "runs": 2, "noise_runs": 40, "n_jobs": 1}


@dataclass(frozen=True)
class Chains(Optimizer):
    """Hill climbers side by side on a torus, where no place differs from another."""

    agents: int = parameter(20, minimum=1)

    def start(self, objective, rng):
        return objective.initial(self.agents)

    def confine(self, objective, x):
        return objective.lower + np.mod(x - objective.lower, objective.upper - objective.lower)

    def minimize(self, objective, rng):
        span, step = objective.upper - objective.lower, np.full((self.agents, 1), 0.2)
        x = self.start(objective, rng)
        f = objective(x)
        while True:
            y = self.confine(objective, x + step * span * rng.standard_normal(x.shape))
            g = objective(y)
            better = g <= f
            x, f = np.where(better[:, None], y, x), np.where(better, g, f)
            step *= np.where(better, 1.5, 1.5**-0.25)[:, None]


@dataclass(frozen=True)
class Shrinking(Chains):
    """Draws ever closer to the centre, whatever it sees."""

    def confine(self, objective, x):
        middle = (objective.lower + objective.upper) / 2
        return middle + 0.5 * (super().confine(objective, x) - middle)


@dataclass(frozen=True)
class Guessing(Chains):
    """Knows where the functions' optimum is moved to."""

    def start(self, objective, rng):
        return (
            super().start(objective, rng) * [[0.0]] + 20.0 if objective.upper[0] > 1 else super().start(objective, rng)
        )


@dataclass(frozen=True)
class Clipping(Chains):
    """Takes what leaves the box back to its bound."""

    def confine(self, objective, x):
        return objective.repair(x)


@dataclass(frozen=True)
class Cornered(Chains):
    """Starts in the lower half of the box."""

    def start(self, objective, rng):
        return objective.lower + 0.5 * (super().start(objective, rng) - objective.lower)


@dataclass(frozen=True)
class Numbered(Chains):
    """Starts where the number of its seed puts it."""

    def start(self, objective, rng):
        place = rng.bit_generator.seed_seq.entropy % 1000 / 1000
        return objective.lower + (objective.upper - objective.lower) * np.full(
            (self.agents, objective.dimension), place
        )


@dataclass(frozen=True)
class Constant(Chains):
    """Starts with the same points in every run."""

    def start(self, objective, rng):
        return np.random.default_rng(0).uniform(objective.lower, objective.upper, (self.agents, objective.dimension))


@dataclass(frozen=True)
class Deterministic(Constant):
    """Does the same in every run."""

    def minimize(self, objective, rng):
        super().minimize(objective, np.random.default_rng(0))


@dataclass(frozen=True)
class Central(Chains):
    """Tries the midpoint of the box before all else."""

    minimum_budget = 1

    def minimize(self, objective, rng):
        objective((objective.lower + objective.upper) / 2)
        super().minimize(objective, rng)


@dataclass(frozen=True)
class Raising(Optimizer):
    """Fails at once."""

    def minimize(self, objective, rng):
        raise ZeroDivisionError("boom")


@dataclass(frozen=True)
class Exiting(Optimizer):
    """Takes its process along."""

    def minimize(self, objective, rng):
        os._exit(1)


@pytest.fixture(autouse=True)
def little_work(monkeypatch):
    """Leave one of the functions, and short runs on it; a worker process of this test's would not know of it."""
    monkeypatch.setattr("bench.check.bias.runs.FUNCTIONS", {"sphere": FUNCTIONS["sphere"]})
    monkeypatch.setattr("bench.check.bias.runs.FUNCTION_BUDGET", 2_000)


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


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_has_its_optimum_where_it_is_said_to_be(name):
    for moved in (False, True):
        problem = function(name, 5, moved=moved)
        place = SHIFT * 2 * HALF_WIDTH * moved
        assert problem.evaluate(np.full((1, 5), place))[0] == pytest.approx(0.0, abs=FLOOR)
        around = np.random.default_rng(0).uniform(-100, 100, (2000, 5))
        assert problem.evaluate(around).min() > 0


def test_noise_depends_on_its_seed_and_the_number_of_evaluations_alone():
    points = np.random.default_rng(0).random((30, 2))
    values = noise((0.0, 1.0), 2, seed=1).evaluate(points)
    again = noise((0.0, 1.0), 2, seed=1)
    assert np.array_equal(np.concatenate([again.evaluate(points[:7] * 0), again.evaluate(points[7:])]), values)
    assert len(set(values)) == 30
    assert not np.array_equal(noise((0.0, 1.0), 2, seed=2).evaluate(points), values)


def test_runs_are_kept_as_shares_of_their_box():
    made = make_runs(Clipping(), dimension=2, runs=1, noise_runs=3)
    assert [len(those) for those in made.noise.values()] == [3, 3]
    for run in (*made.noise["[-1, 1]"], *made.centred["sphere"]):
        assert run.first.shape == (20, 2)
        assert 0.2 < run.first.mean() < 0.8
        assert ((run.x >= 0) & (run.x <= 1)).all()
    assert made.centred["sphere"][0].x == pytest.approx(0.5, abs=1e-3)
    assert made.moved["sphere"][0].x == pytest.approx(0.6, abs=1e-3)
    assert all(0 < run.clamped < 0.5 for run in made.noise["[0, 1]"])


def test_a_failing_optimizer_is_named_with_its_error():
    with pytest.raises(BenchError, match="failed on sphere: ZeroDivisionError: boom"):
        diagnose(Raising(), n_jobs=1)


def test_an_optimizer_that_ends_its_process_is_told_in_a_sentence():
    cloudpickle.register_pickle_by_value(sys.modules[__name__])  # workers cannot import this module
    try:
        with pytest.raises(BenchError, match="ended its worker process"):
            diagnose(Exiting(), n_jobs=2)
    finally:
        cloudpickle.unregister_pickle_by_value(sys.modules[__name__])


def test_every_check_has_its_place_in_the_report():
    from bench.analysis.integrity import TRAITS

    assert list(TRAITS) == CHECKS
    assert len(diagnosis.CHECKS) == len(CHECKS)
