"""The record of a run, and findings on runs that differ and on processes that are lost."""

import random

import numpy as np
import pytest

from bench.check import problems
from bench.check.conformance.recording import (
    LET_IT_PASS,
    RecordedRun,
    ViolationError,
    expect_same,
    explain_lost_process,
)
from bench.check.conformance.subject import Subject
from bench.sandbox.process import DiedError, LostError, PrintedTooMuchError, TimeExceededError
from bench.sandbox.server import STILL_ASKING
from tests.bench.check import faulty, unrepeatable


def record(optimizer, budget=40, **options):
    return Subject(optimizer, seed=1, **options).run(problems.bowl(), budget=budget)


def test_a_sound_run_uses_its_budget_and_nothing_else():
    run = record(faulty.Sound())
    assert run.points.shape == (40, 3)
    assert (run.stop, run.asked_after) == ("budget", 0)
    assert (run.reached, run.touched) == (set(), ())
    assert run.course() == record(faulty.Sound()).course()
    assert len(set(run.course())) == 40


@pytest.mark.parametrize(
    ("optimizer", "attribute", "value"),
    [
        (faulty.Stubborn(), "asked_after", 2),
        (faulty.Tired(), "stop", "tired"),
        (unrepeatable.Legacy(), "touched", ("numpy.random",)),
        (faulty.Spying(), "reached", {"_problem"}),
        (faulty.Boasting(), "reached", {"fun"}),
        (faulty.Careful(), "reached", set()),
    ],
)
def test_what_a_run_does_is_recorded(optimizer, attribute, value):
    assert getattr(record(optimizer), attribute) == value


def test_the_global_random_states_are_restored():
    before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    record(unrepeatable.Legacy())
    assert (random.getstate(), np.random.get_state()[1].tolist()) == before  # noqa: NPY002


def course(*points):
    return RecordedRun(np.array(points, dtype=float).reshape(-1, 1)).course()


@pytest.mark.parametrize(("one", "other", "evaluation"), [((1, 2), (1, 3), 2), ((0,), (1,), 1), ((1, 2), (1,), 2)])
def test_the_first_evaluation_that_differs_is_named(one, other, evaluation):
    with pytest.raises(ViolationError) as caught:
        expect_same(course(*one), course(*other), "they differ", "mend it")
    assert caught.value.finding == f"they differ (from evaluation {evaluation} on)"
    assert caught.value.remedy == "mend it"


@pytest.mark.parametrize(
    ("error", "noted", "finding", "remedy"),
    [
        (DiedError(STILL_ASKING), [9, 9], "for ever after its budget of 9 is spent", LET_IT_PASS),
        (DiedError(3), [2, 9], "it ended the process that it ran in (exit code 3)", "raise an exception"),
        (LostError("it was stopped"), [2, 9], "it stopped the process that it ran in", "send no signals"),
        (PrintedTooMuchError(), [2, 9], "it printed without end", "print and log nothing"),
        (TimeExceededError("30 s"), [9, 9], "did not end within 30 s, after its budget of 9 was spent", LET_IT_PASS),
        (TimeExceededError("30 s"), [2, 9], "did not end within 30 s, after 2 of 9 evaluations", "never calls"),
        (TimeExceededError("30 s"), None, "did not end within 30 s, after 0 of its evaluations", "never calls"),
        (TimeExceededError("30 s"), ["2", 9], "after 0 of its evaluations", "never calls"),
        (TimeExceededError("30 s"), {"made": 2}, "after 0 of its evaluations", "never calls"),
    ],
)
def test_a_lost_process_is_explained_by_its_last_note(error, noted, finding, remedy):
    said, advice = explain_lost_process(error, noted)
    assert finding in said
    assert remedy in advice
