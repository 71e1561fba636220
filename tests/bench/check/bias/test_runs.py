"""The runs from which biases are diagnosed."""

import pytest

from bench import load_optimizer
from bench.check.bias.runs import BOXES, make_runs
from tests.bench.check.bias.biased import Chains, Clipping

pytestmark = pytest.mark.usefixtures("little_work")


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
