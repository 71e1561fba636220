"""The rules of isolation."""

import pytest

from bench.check.conformance.rules import RULES
from tests.bench.check import faulty, unrepeatable
from tests.bench.check.conformance.examine import expect_broken, failures, verdicts

FAULTS = [
    (unrepeatable.Clocked, "repetition", "two runs of one seed differ (from evaluation 5 on)", "draw from rng alone"),
    (unrepeatable.Fixed, "repetition", "its moves from equal starts are equal for every seed", "draw from rng"),
    (unrepeatable.Timed, "clock", "where its clocks go fast, it does otherwise (from evaluation 5 on)", "use no clock"),
    (unrepeatable.Stale, "leader", "changes at most 0% of the points after it", "keep point and value"),
    (unrepeatable.Counting, "repetition", "two runs of one seed differ", "kept in the module"),
    (
        unrepeatable.Remembering,
        "no state",
        "a second run of one instance differs from that of a new one",
        "local variables",
    ),
    (unrepeatable.Adapting, "no state", "changes its 'step' from 0.1 to 0.2", "local variables"),
    (unrepeatable.Locked, "pickling", "TypeError: cannot pickle '_thread.lock' object", "plain values"),
    (unrepeatable.Legacy, "global states", "changes the global random state of numpy.random", "draw from rng alone"),
    (unrepeatable.Peeking, "global states", "depends on the global random states", "draw from rng alone"),
    (
        faulty.Knowing,
        "anonymity",
        "depends on the problem's name, variables or known optimum",
        "nothing of the problem",
    ),
    (faulty.Spying, "contract", "it reads or sets _problem of the objective", ".initial(n)"),
    (faulty.Boasting, "contract", "it reads or sets fun of the objective", ".initial(n)"),
    (faulty.Stretching, "contract", "it reads or sets upper of the objective", ".initial(n)"),
    (faulty.Chatty, "silence", "such as 'generation ", "print and log nothing"),
    (faulty.Loud, "silence", "such as 'iterating'", "print and log nothing"),
    (faulty.Littering, "leftovers", "1 file in the working folder, such as 'outwalker.log'", "write no files"),
]


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "remedy"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, remedy):
    expect_broken(optimizer, rule, finding, remedy)


@pytest.mark.parametrize("optimizer", [unrepeatable.Hashing, unrepeatable.Foreign])
def test_a_run_that_depends_on_its_process_is_found(optimizer):
    found = failures(verdicts(optimizer, RULES))
    assert [verdict.check for verdict in found] == ["processes"]
    assert "another run in another process" in found[0].finding
    assert "do not loop over a set" in found[0].remedy


def test_a_copy_of_another_class_is_found():
    found = failures(verdicts(unrepeatable.Changeling))
    assert [verdict.check for verdict in found] == ["pickling"]
    assert found[0].finding == "its pickled copy is a Sound, not a Changeling"


def test_a_copy_that_loses_a_parameter_is_found():
    found = failures(verdicts(unrepeatable.Forgetful, step=0.3))
    assert [verdict.check for verdict in found] == ["pickling"]
    assert found[0].finding == "its pickled copy has other parameters"
