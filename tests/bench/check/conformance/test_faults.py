"""Faulty optimizers: each breaks its own rule alone, and the finding says how to mend it."""

from textwrap import dedent

import pytest

from bench.check.conformance.rules import RULES
from tests.bench.check import faulty, unrepeatable
from tests.bench.check.conformance.examine import expect_broken, failures, verdicts

FAULTS = [
    (faulty.Thawed, "parameters", "Thawed is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Broken, "run", "it raised ZeroDivisionError: by zero", "fix what raises"),
    (faulty.Stubborn, "budget", "2 more times after the budget of 1 was spent", "let BudgetExhausted pass"),
    (faulty.Escaping, "box", "lie outside the box, such as [", "clip to objective.lower"),
    (faulty.Planar, "dimensions", "index 1 is out of bounds for axis 1 with size 1 in 1 dimension", "any dimension"),
    (faulty.Finite, "values", "it raised ValueError: autodetected range of", "+inf can occur"),
    (unrepeatable.Clocked, "repetition", "two runs of one seed differ (from evaluation 5 on)", "draw from rng alone"),
    (unrepeatable.Timed, "clock", "where its clocks go fast, it does otherwise (from evaluation 5 on)", "use no clock"),
    (unrepeatable.Stale, "leader", "changes at most 0% of the points after it", "keep point and value"),
    (unrepeatable.Remembering, "no state", "a second run of one instance differs from that of", "local variables"),
    (unrepeatable.Locked, "pickling", "TypeError: cannot pickle '_thread.lock' object", "plain values"),
    (unrepeatable.Legacy, "global states", "changes the global random state of numpy.random", "draw from rng alone"),
    (faulty.Knowing, "anonymity", "depends on the problem's name, variables or known optimum", "nothing of the"),
    (faulty.Spying, "contract", "it reads or sets _problem of the objective", ".initial(n)"),
    (faulty.Chatty, "silence", "such as 'generation ", "print and log nothing"),
    (faulty.Littering, "leftovers", "1 file in the working folder, such as 'outwalker.log'", "write no files"),
    # parameters
    (faulty.Plain, "parameters", "Plain is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Undecorated, "parameters", "'step' of Undecorated looks like a parameter", "above Undecorated too"),
    (faulty.Greedy, "parameters", "takes anything as 'step'", "call super().__post_init__()"),
    (faulty.Hasty, "parameters", "a wrong 'step' raises TypeError", "before anything else"),
    (faulty.Empty, "parameters", "it takes agents=0", "the least population that the method works with"),
    (faulty.Crowded, "parameters", "it fails with agents=1, the least", "declare the least population"),
    (faulty.Demanding, "parameters", "'step' has no default", "a default"),
    (faulty.Abstract, "parameters", "no method minimize", "write minimize"),
    (faulty.Misfit, "parameters", "BenchError: parameter 'step' of Misfit must be a whole number", "that fit"),
    # robustness
    (faulty.Idle, "run", "without a single evaluation", "ask objective(x)"),
    (faulty.Rounding, "budget", "without a single evaluation of a budget of 1", "below one generation"),
    (faulty.Surplus, "budget", "first generation has 7 points, one more than its population of 6", "as many points"),
    (faulty.Ranging, "values", "points that are not finite with equal values", "guard divisions"),
    (faulty.Content, "values", "returned after 4 of 150 evaluations with equal values", "objective.stop"),
    # isolation
    (unrepeatable.Fixed, "repetition", "its moves from equal starts are equal for every seed", "draw from rng"),
    (unrepeatable.Counting, "repetition", "two runs of one seed differ", "kept in the module"),
    (unrepeatable.Adapting, "no state", "changes its 'step' from 0.1 to 0.2", "local variables"),
    (unrepeatable.Peeking, "global states", "depends on the global random states", "draw from rng alone"),
    (faulty.Boasting, "contract", "it reads or sets fun of the objective", ".initial(n)"),
    (faulty.Stretching, "contract", "it reads or sets upper of the objective", ".initial(n)"),
    (faulty.Loud, "silence", "such as 'iterating'", "print and log nothing"),
]
"""The first of them break a rule each; the others are slow."""


@pytest.mark.sampled(16)
@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "remedy"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, remedy):
    expect_broken(verdicts(optimizer), rule, finding, remedy)


@pytest.mark.parametrize("optimizer", [unrepeatable.Hashing, unrepeatable.Foreign])
def test_a_run_that_depends_on_its_process_is_found(optimizer):
    found = failures(verdicts(optimizer, RULES))
    assert [verdict.check for verdict in found] == ["processes"]
    assert "another run in another process" in found[0].finding
    assert "do not loop over a set" in found[0].remedy


@pytest.mark.parametrize(
    ("optimizer", "options", "finding"),
    [
        (unrepeatable.Changeling, {}, "its pickled copy is a Sound, not a Changeling"),
        (unrepeatable.Forgetful, {"step": 0.3}, "its pickled copy has other parameters"),
    ],
)
def test_a_copy_of_another_class_or_that_loses_a_parameter_is_found(optimizer, options, finding):
    assert [(each.check, each.finding) for each in failures(verdicts(optimizer, **options))] == [("pickling", finding)]


def test_what_a_constructor_raises_is_a_verdict_under_any_name(tmp_path):
    (tmp_path / "mine.py").write_text(
        dedent(
            """
            from dataclasses import dataclass
            import bench

            @dataclass(frozen=True)
            class Mine(bench.Optimizer):
                def __post_init__(self):
                    raise OSError("no licence")

                def minimize(self, objective, rng): ...
            """
        )
    )
    found = verdicts("mine.py:Mine")
    assert found.keys() == {"parameters"}
    assert "OSError: no licence" in found["parameters"].finding
