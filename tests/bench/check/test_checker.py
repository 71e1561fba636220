"""``check_optimizer``, its report and its biases; rules are checked once, in order and in a process of their own."""

from contextlib import closing
from dataclasses import replace

import pytest

from bench import BenchError
from bench.check import check_optimizer, check_problem
from bench.check.checker import Checker
from bench.check.conformance.problem_subject import ProblemSubject
from bench.check.conformance.rules import RULES, find_rule
from bench.check.conformance.subject import Subject
from tests.bench.check import faulty, faulty_problems, unrepeatable
from tests.bench.check.conformance.examine import ALL, expect_broken

HURRIED = {faulty.Hanging: 8.0, faulty.Stuck: 2.0}  # seconds, where the check would take all its time


def test_the_readme_s_optimizer_passes_with_a_readable_report():
    heard = []
    checkup = check_optimizer("hill-climber", bias=False, on_check=heard.append)
    assert checkup
    assert checkup.passed
    assert heard == list(checkup) == list(checkup.verdicts)
    assert [verdict.check for verdict in checkup] == [rule.name for rule in RULES]
    lines = str(checkup).splitlines()
    assert lines[0] == "hill-climber"
    assert lines[-1] == checkup.summary == "hill-climber keeps the contract"
    assert all(line.startswith("  passed  ") for line in lines[1:-1])


def test_a_failed_report_says_how_to_mend_it_and_what_could_not_be_checked():
    checkup = check_optimizer(unrepeatable.Clocked, bias=False)
    assert not checkup
    assert not checkup.passed
    assert checkup.label == "Clocked"
    assert checkup.unchecked == (
        "processes", "no state", "pickling", "global states", "clock", "leader", "anonymity", "invariances",
        "idle parameters",
    )  # fmt: skip
    text = str(checkup)
    assert "  FAILED  repetition" in text
    assert "remedy: draw from rng alone" in text
    assert text.endswith(
        "Clocked fails the contract in: repetition; not checked until that is fixed: "
        "processes, no state, pickling, global states, clock, leader, anonymity, invariances, idle parameters"
    )


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: check_optimizer(faulty.Sound(), agents=3), "'agents' cannot be set: the optimizer is made already"),
        (
            lambda: check_optimizer("gwo", seed=-1),
            "the seed must be a whole number from 0 to 9223372036854775807, not -1",
        ),
    ],
)
def test_what_cannot_be_checked_at_all_is_refused_in_a_sentence(call, said):
    with pytest.raises(BenchError) as caught:
        call()
    assert said in str(caught.value)


def test_an_optimizer_that_cannot_keep_its_budget_is_not_searched_for_biases():
    assert {verdict.kind for verdict in check_optimizer(faulty.Idle)} == {"conformance"}


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("optimizer", "check", "finding", "remedy"),
    [
        (
            unrepeatable.Cached,
            "processes",
            "another run in another process, after other runs",
            "or the class from run to run",
        ),
        (faulty.Endless, "run", "for ever after its budget of 150 is spent", "let BudgetExhausted pass"),
        pytest.param(
            faulty.Hanging,
            "run",
            "did not end within 8 s, after its budget of 150 was spent",
            "let BudgetExhausted pass",
            marks=pytest.mark.slow,
        ),
        (faulty.Stuck, "box", "it did not end within 2 s, after 0 of 600 evaluations", "never calls the objective"),
        (faulty.Quitting, "values", "ended the process that it ran in (exit code 3)", "raise an exception"),
        (faulty.Interrupting, "dimensions", "it raised KeyboardInterrupt: no message", "any dimension"),
        (faulty.Crashing, "dimensions", "ended the process that it ran in (", "crash in compiled code"),
        (faulty.Forging, "values", "its process gave an answer that is no verdict", "leave the harness's objects"),
        (faulty.Answering, "dimensions", "it sent what answers no call", ""),
        (faulty.Threaded, "leftovers", "every run leaves a thread running", "in a finally"),
    ],
)
def test_what_hangs_crashes_or_spoils_its_process_costs_its_own_check_alone(optimizer, check, finding, remedy):
    seconds = HURRIED.get(optimizer, find_rule(check).seconds)
    rules = [replace(rule, seconds=seconds) if rule.name == check else rule for rule in RULES]
    with closing(Checker(Subject(optimizer))) as checker:
        found = {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}
    expect_broken(found, check, finding, remedy)
    assert found.keys() == ({"parameters", "run"} if check == "run" else ALL)


FORGES = """
from bench.check import checker
from bench.check.verdict import Verdict

checker._judge = lambda packed, name: Verdict(name, "conformance", True, "it says so").as_dict()

def mine(objective, rng):
    import random

    random.random()
    objective(objective.initial(5))
"""


@pytest.mark.parametrize("forged", [False, True])
def test_an_optimizer_that_answers_in_place_of_its_check_passes(tmp_path, forged):
    (tmp_path / "mine.py").write_text(FORGES if forged else FORGES[FORGES.index("def mine") :])
    with closing(Checker(Subject(f"{tmp_path}/mine.py:mine"))) as checker:
        verdict = checker.verdict(find_rule("global states"))
    assert verdict.passed is forged


def test_a_problem_is_checked_in_a_process_of_its_own_and_the_report_says_what_was_left_out():
    checkup = check_problem(faulty_problems.Raising)
    assert not checkup
    assert [verdict.check for verdict in checkup if not verdict.passed] == ["values"]
    assert "RuntimeError: no licence" in str(checkup)
    assert {"batches", "processes", "leftovers"} <= set(checkup.unchecked)


@pytest.mark.parametrize(
    ("problem", "check", "finding"),
    [
        (faulty_problems.Hashed, "processes", "a seed gives another run in another process"),
        (faulty_problems.Unpicklable, "pickling", "it raised TypeError: cannot pickle"),
    ],
)
@pytest.mark.sampled(1)
def test_what_needs_another_process_is_found_of_a_problem(problem, check, finding):
    (broken,) = [verdict for verdict in check_problem(problem) if not verdict.passed]
    assert broken.check == check
    assert finding in broken.finding


@pytest.mark.slow
def test_a_problem_that_hangs_costs_a_verdict():
    values = replace(find_rule("values", "problem"), seconds=1.0)
    with closing(Checker(ProblemSubject(faulty_problems.Hanging))) as checking:
        assert "did not end within 1 s" in checking.verdict(values).finding
