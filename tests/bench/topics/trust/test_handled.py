"""What a reader must know of evaluations that failed and of trials that a limit of time has ended."""

import pandas as pd

from bench.topics.trust.section import handled


def frame(**changes):
    rows = {"problem": ["p", "p", "q"], "nfev": [50, 50, 100], "failures": [0, 0, 0], "stop": ["budget"] * 3}
    return pd.DataFrame(rows | changes)


def test_failed_evaluations_are_counted_by_problem():
    ((label, sentence, _),) = handled(frame(failures=[1, 2, 0]))
    assert label == "failed evaluations"
    assert sentence == "Evaluations failed, and count with the value +inf: a share of 0.03 of those on p."


def test_trials_that_a_limit_of_time_has_ended_are_counted():
    ((label, sentence, _),) = handled(frame(stop=["time", "budget", "time"]))
    assert label == "ended by time"
    assert sentence.startswith("A limit of time has ended 2 of 3 trials before the budget: their results depend")
