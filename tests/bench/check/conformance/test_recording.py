"""The record of a run."""

import random

import numpy as np
import pytest

from bench.check import problems
from bench.check.conformance.subject import Subject
from tests.bench.check import faulty


def record(optimizer, budget=40, **options):
    return Subject(optimizer, seed=1, **options).run(problems.bowl(), budget=budget)


def test_a_sound_run_uses_its_budget_and_nothing_else():
    run = record(faulty.Sound())
    assert run.points.shape == (40, 3)
    assert (run.stop, run.asked_after, run.outside) == ("budget", 0, 0)
    assert (run.reached, run.touched, run.drew) == (set(), (), True)
    assert run.course() == record(faulty.Sound()).course()
    assert len(set(run.course())) == 40


@pytest.mark.parametrize(
    ("optimizer", "attribute", "value"),
    [
        (faulty.Stubborn(), "asked_after", 2),
        (faulty.Tired(), "stop", "tired"),
        (faulty.Deterministic(), "drew", False),
        (faulty.Legacy(), "touched", ("numpy.random",)),
        (faulty.Spying(), "reached", {"_problem"}),
        (faulty.Boasting(), "reached", {"best_value"}),
        (faulty.Careful(), "reached", set()),
    ],
)
def test_what_a_run_does_is_recorded(optimizer, attribute, value):
    assert getattr(record(optimizer), attribute) == value


def test_points_outside_the_box_are_counted():
    assert record(faulty.Escaping(), budget=400).outside > 0


def test_a_run_without_an_evaluation_has_no_points():
    run = record(faulty.Idle())
    assert run.points.shape == (0, 3)
    assert run.stop == "undeclared"


def test_what_the_optimizer_raises_passes_through():
    with pytest.raises(ZeroDivisionError):
        record(faulty.Broken())


def test_pulses_count_evaluations_to_the_end_of_the_budget():
    pulses = []
    record(faulty.Sound(), budget=10, pulse=lambda made, budget: pulses.append((made, budget)))
    assert pulses == [(4, 10), (8, 10), (10, 10)]


def test_the_global_random_states_are_restored():
    before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    record(faulty.Legacy())
    assert (random.getstate(), np.random.get_state()[1].tolist()) == before  # noqa: NPY002
