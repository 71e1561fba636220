"""Findings on runs that differ and on processes that are lost."""

from types import SimpleNamespace

import numpy as np
import pytest

from bench.check.conformance.recording import RecordedRun
from bench.check.conformance.violation import LET_IT_PASS, ViolationError, expect_same, explain_lost_process
from bench.execution.trial_process import STILL_ASKING
from bench.sandbox.process import DiedError, SilentError


def run(*points):
    return RecordedRun(np.array(points, dtype=float).reshape(-1, 1)).course()


def test_equal_runs_pass():
    expect_same(run(1, 2), run(1, 2), "they differ", "")


@pytest.mark.parametrize(("one", "other", "evaluation"), [((1, 2), (1, 3), 2), ((0,), (1,), 1), ((1, 2), (1,), 2)])
def test_the_first_evaluation_that_differs_is_named(one, other, evaluation):
    with pytest.raises(ViolationError) as caught:
        expect_same(run(*one), run(*other), "they differ", "mend it")
    assert caught.value.finding == f"they differ (from evaluation {evaluation} on)"
    assert caught.value.mend == "mend it"


@pytest.mark.parametrize(
    ("error", "pulse", "finding", "mend"),
    [
        (DiedError(STILL_ASKING), (9, 9), "for ever after its budget of 9 is spent", LET_IT_PASS),
        (DiedError(3), (2, 9), "it ended the process that it ran in (exit code 3)", "raise an exception"),
        (SilentError("30 s"), (9, 9), "it did not end within 30 s after its budget of 9 was spent", LET_IT_PASS),
        (SilentError("30 s"), (2, 9), "it asked for no value for 30 s, after 2 evaluations", "never calls"),
        (SilentError("30 s"), None, "it asked for no value for 30 s, after 0 evaluations", "never calls"),
    ],
)
def test_a_lost_process_is_explained_by_its_last_pulse(error, pulse, finding, mend):
    said, advice = explain_lost_process(error, SimpleNamespace(pulse=pulse))
    assert finding in said
    assert mend in advice
