"""The rules of the contract as cases of pytest: each test here is one run of pytest on the tests of an author."""

from textwrap import dedent

import pytest

from bench import BenchError
from bench.check.conformance.rules import RULES
from bench.testing import parametrize_with_checks

pytest_plugins = ["pytester"]

IDS = [rule.name.replace(" ", "-") for rule in RULES]

AUTHOR = """
import os
import threading
import time
from dataclasses import dataclass, field

import numpy as np

import bench.check.checker
from bench import Optimizer
from bench.testing import parametrize_with_checks


@dataclass(frozen=True)
class Sound(Optimizer):
    step: float = 0.1

    def minimize(self, objective, rng):
        while True:
            self.look(objective(objective.initial(4)))

    def look(self, values):
        pass


class Chatty(Sound):
    def look(self, values):
        print("generation", values.min())


class Quitting(Sound):
    def look(self, values):
        if values.min() == values.max() == 0:
            os._exit(3)


@dataclass(frozen=True)
class Clocked(Sound):
    def minimize(self, objective, rng):
        clock = np.random.default_rng(time.perf_counter_ns())
        while True:
            points = clock.uniform(objective.lower, objective.upper, (4, objective.dimension))
            self.look(objective(objective.repair(points)))


@dataclass(frozen=True)
class Locked(Sound):
    lock: object = field(default_factory=threading.Lock, compare=False, repr=False)
"""


@pytest.fixture
def author(pytester):
    """Return a function that runs pytest on an author's tests and returns outcomes by id, and what was printed."""

    def run(decorator, *arguments, setup=""):
        test = f"\n{setup}\n{decorator}\ndef test_conforms(check):\n    check()\n"
        pytester.makepyfile(test_author=dedent(AUTHOR) + test)
        done = pytester.runpytest_subprocess("-rA", "-vv", "-p", "no:cacheprovider", "-p", "no:xdist", *arguments)
        outcomes = {}
        for line in done.outlines:
            name, bracket, rest = line.partition("::test_conforms[")
            if name == "test_author.py" and bracket:
                label, _, outcome = rest.partition("] ")
                outcomes[label] = outcome.split()[0] if outcome else ""
        return outcomes, done.stdout.str()

    return run


def all_but(optimizer, **other):
    return {f"{optimizer}-{name}": "PASSED" for name in IDS} | {f"{optimizer}-{name}": o for name, o in other.items()}


@pytest.mark.slow
def test_a_broken_rule_fails_its_own_id_alone_and_says_how_to_fix_it(author):
    outcomes, printed = author("@parametrize_with_checks([Chatty, Quitting])")
    assert outcomes == all_but("Chatty", silence="FAILED") | all_but("Quitting", values="FAILED")
    assert "Chatty breaks the rule 'silence': a run printed" in printed
    assert "remedy: print and log nothing" in printed
    assert "Quitting breaks the rule 'values': it ended the process that it ran in (exit code 3)" in printed
    assert "Traceback" not in printed


@pytest.mark.slow
def test_a_rule_that_needs_a_broken_one_is_skipped(author):
    outcomes, printed = author("@parametrize_with_checks([Clocked])")
    needing = (
        "processes", "clock", "leader", "no-state", "pickling", "global-states", "anonymity", "invariances",
        "idle-parameters",
    )  # fmt: skip
    assert outcomes == all_but("Clocked", repetition="FAILED", **dict.fromkeys(needing, "SKIPPED"))
    assert "not checked, because Clocked breaks the rule 'repetition'" in printed


@pytest.mark.slow
def test_a_failure_can_be_expected_and_must_then_occur(author):
    outcomes, printed = author("@parametrize_with_checks([Chatty, Sound], expected_failures={'silence': 'a banner'})")
    assert outcomes == all_but("Chatty", silence="XFAIL") | all_but("Sound", silence="FAILED")
    assert "XFAIL test_author.py::test_conforms[Chatty-silence] - a banner" in printed
    assert "[XPASS(strict)] a banner" in printed


@pytest.mark.parametrize(
    ("optimizers", "expected", "sentence"),
    [
        ("gwo", None, "give a list of optimizers, such as ['gwo']"),
        ([], None, "give at least one optimizer to check"),
        (["gwo"], {"no-state": "known"}, "unknown rule 'no-state'; did you mean 'no state'?"),
        (["gwo"], {"silence": ""}, "expected_failures must give the reason for 'silence' as a text, not ''"),
    ],
)
def test_what_cannot_be_checked_is_refused_in_a_sentence(optimizers, expected, sentence):
    with pytest.raises(BenchError) as caught:
        parametrize_with_checks(optimizers, expected_failures=expected)
    assert sentence in str(caught.value)


@pytest.mark.slow
def test_the_rules_of_problems_are_cases_too(author):
    setup = """
import bench

from bench.testing import parametrize_with_problem_checks

def values(x):
    return (x**2).sum(axis=1) if len(x) < 40 else np.full(len(x), np.nan)

low, high = bench.FunctionProblem(lambda x: x[:, 0], [0], [1], name="low"), bench.FunctionProblem(values, [0], [1])
"""
    outcomes, printed = author("@parametrize_with_problem_checks([low, high])", "-k", "values or repair", setup=setup)
    assert outcomes == {
        "low-values": "PASSED", "low-repair": "PASSED", "function-values": "FAILED", "function-repair": "PASSED",
    }  # fmt: skip
    assert "function breaks the rule 'values': " in printed
