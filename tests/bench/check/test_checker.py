"""``check_optimizer``, its report and its biases; rules are checked once, in order and in a process of their own."""

import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from textwrap import dedent

import pytest

import bench
from bench import BenchError, load_optimizer
from bench.check import check_optimizer, check_problem, checker
from bench.check.checker import Checker
from bench.check.conformance.problem_subject import ProblemSubject
from bench.check.conformance.rules import RULES, failed, find_rule
from bench.check.conformance.subject import Subject
from bench.check.verdict import Verdict
from tests.bench.check import faulty, faulty_problems
from tests.bench.check.conformance.examine import ALL, failures

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
    checkup = check_optimizer(faulty.Clocked, bias=False)
    assert not checkup
    assert not checkup.passed
    assert checkup.label == "Clocked"
    assert checkup.unchecked == (
        "processes", "no state", "pickling", "global states", "anonymity", "invariances", "idle parameters",
    )  # fmt: skip
    text = str(checkup)
    assert "  FAILED  repetition" in text
    assert "remedy: draw from rng alone" in text
    assert text.endswith(
        "Clocked fails the contract in: repetition; not checked until that is fixed: "
        "processes, no state, pickling, global states, anonymity, invariances, idle parameters"
    )


@pytest.mark.slow
def test_classes_of_a_script_and_of_a_function_can_be_checked(tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(
        dedent(
            """
            from __future__ import annotations
            from dataclasses import dataclass
            from typing import ClassVar, Literal
            import bench

            @dataclass(frozen=True)
            class Base(bench.Optimizer):
                code: ClassVar[str] = "mine"
                way: Literal["far", "near"] = "far"

            def local() -> type:
                @dataclass(frozen=True)
                class Mine(Base):
                    step: float = 0.1

                    def minimize(self, objective, rng):
                        while True:
                            objective(objective.initial(3))
                return Mine

            checkup = bench.check_optimizer(local(), bias=False)
            assert checkup, str(checkup)
            assert len(checkup.verdicts) == 18, str(checkup)
            """
        )
    )
    subprocess.run([sys.executable, script], check=True, timeout=300, cwd=tmp_path)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: check_optimizer("gwp"), "unknown optimizer 'gwp'; did you mean 'gwo'?"),
        (lambda: check_optimizer(faulty.Sound(), agents=3), "'agents' cannot be set: the optimizer is made already"),
        (
            lambda: check_optimizer(3),
            "give the name of a plug-in of bench.optimizers, a subclass of Optimizer or an instance of one, not 3",
        ),
        (
            lambda: check_optimizer("gwo", seed=-1),
            "the seed must be a whole number from 0 to 9223372036854775807, not -1",
        ),
        (lambda: check_optimizer(faulty.Sound, agentss=3), "no parameter 'agentss'; did you mean 'agents'?"),
    ],
)
def test_what_cannot_be_checked_at_all_is_refused_in_a_sentence(call, said):
    with pytest.raises(BenchError) as caught:
        call()
    assert said in str(caught.value)


@pytest.fixture
def conforming(monkeypatch):
    """Spare the checks of the contract."""
    monkeypatch.setattr(Checker, "verdict", lambda self, rule: Verdict(rule.name, "conformance", True, "well"))


def test_biases_are_looked_for_with_the_optimizer_s_own_parameters(conforming, monkeypatch):
    asked = []

    def diagnose(optimizer, *, n_jobs, seed, sandbox):
        asked.append((optimizer, n_jobs, seed))
        return [Verdict("centre bias", "bias", False, "drawn to the centre", "report it", 99.0)]

    monkeypatch.setattr("bench.check.bias.diagnose", diagnose)
    checkup = bench.check_optimizer("gwo", agents=5, n_jobs=1, seed=7)
    assert asked == [(load_optimizer("gwo", agents=5), 1, 7)]
    assert checkup.conforms
    assert checkup
    assert not checkup.passed
    assert checkup.summary == "gwo keeps the contract; biased: fails the checks of centre bias"


def test_a_diagnosis_that_fails_is_a_verdict_too(conforming, monkeypatch):
    def diagnose(optimizer, *, n_jobs, seed, sandbox):
        raise RuntimeError("no noise today")

    monkeypatch.setattr("bench.check.bias.diagnose", diagnose)
    checkup = check_optimizer("gwo")
    assert checkup.verdicts[-1].kind == "bias"
    assert checkup.verdicts[-1].finding == "it could not be examined: RuntimeError: no noise today"


def test_an_optimizer_that_cannot_keep_its_budget_is_not_searched_for_biases(monkeypatch):
    monkeypatch.setattr("bench.check.bias.diagnose", lambda *_, **__: pytest.fail("was asked"))
    assert not check_optimizer(faulty.Idle)


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("optimizer", "check", "finding", "remedy"),
    [
        (
            faulty.Cached,
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
        (
            faulty.Forging,
            "values",
            "its process gave an answer that is no verdict",
            "leave the harness's objects alone",
        ),
        (faulty.Answering, "dimensions", "it sent what answers no call", ""),
        (faulty.Threaded, "leftovers", "every run leaves a thread running", "in a finally"),
    ],
)
def test_what_hangs_crashes_or_spoils_its_process_costs_its_own_check_alone(optimizer, check, finding, remedy):
    seconds = HURRIED.get(optimizer, find_rule(check).seconds)
    rules = [replace(rule, seconds=seconds) if rule.name == check else rule for rule in RULES]
    with closing(Checker(Subject(optimizer))) as checker:
        found = {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}
    assert [verdict.check for verdict in failures(found)] == [check]
    assert finding in found[check].finding
    assert remedy in found[check].remedy
    assert found.keys() == ({"parameters", "run"} if check == "run" else ALL)


def test_an_instance_that_cannot_be_pickled_is_told_so():
    checkup = check_optimizer(faulty.Locked(), bias=False)
    assert [(verdict.check, verdict.passed) for verdict in checkup] == [("pickling", False)]
    assert "it cannot be sent to another process: TypeError: cannot pickle" in checkup.verdicts[0].finding


def test_a_class_that_no_other_process_can_load_is_told_so(monkeypatch):
    monkeypatch.setattr(checker, "pack", lambda subject: b"nothing of the kind")
    checkup = check_optimizer(faulty.Sound, bias=False)
    assert [(verdict.check, verdict.passed) for verdict in checkup] == [("pickling", False)]
    assert "another process cannot load it: UnpicklingError" in checkup.verdicts[0].finding


def test_a_process_that_dies_while_it_loads_is_told(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(
        "import os\nif 'PYTHONIOENCODING' in os.environ: os._exit(9)\ndef go(f, rng): ..."
    )
    monkeypatch.delenv("PYTHONIOENCODING", raising=False)
    checkup = check_optimizer("mine.py:go", bias=False)
    assert checkup.summary.startswith("mine.py:go fails the contract in: parameters")
    assert "ended the process that it ran in (exit code 9)" in checkup.verdicts[0].finding


class Mock(Checker):
    """Fails the rules of ``broken``, has no verdict on those of ``silent``, and counts its judgements."""

    def __init__(self, broken=(), silent=()):
        super().__init__(Subject("mock"))
        self.broken, self.silent, self.asked = broken, silent, []

    def _judge(self, rule):
        self.asked.append(rule.name)
        if rule.name in self.silent:
            return None
        return failed(rule, "seen") if rule.name in self.broken else Verdict(rule.name, "conformance", True, "well")


def test_a_rule_is_judged_once_and_after_those_that_it_needs():
    checker = Mock()
    assert checker.verdict(find_rule("pickling")).passed
    assert checker.verdict(find_rule("pickling")).passed
    assert checker.asked == ["run", "repetition", "pickling"]
    assert len([*filter(None, map(checker.verdict, RULES))]) == 18


@pytest.mark.parametrize(
    ("checker", "obstacle"),
    [
        (Mock(broken=["run", "repetition"]), "run"),
        (Mock(broken=["repetition"]), "repetition"),
        (Mock(broken=["parameters"], silent=["run"]), "parameters"),
    ],
)
def test_the_obstacle_of_a_rule_is_the_first_broken_one(checker, obstacle):
    assert checker.verdict(find_rule("pickling")) is None
    assert checker.obstacle(find_rule("pickling")).name == obstacle


def test_an_optimizer_that_cannot_be_sent_is_packed_once(monkeypatch):
    asked = []

    def pack(subject):
        asked.append(subject)
        raise TypeError("cannot pickle it")

    monkeypatch.setattr(checker, "pack", pack)
    unsendable = Checker(Subject(faulty.Sound))
    assert [unsendable.verdict(rule) for rule in RULES[:2]] == [None, None]
    assert unsendable.unloadable == "it cannot be sent to another process: TypeError: cannot pickle it"
    assert unsendable.verdict(find_rule("pickling")).finding == unsendable.unloadable
    assert len(asked) == 1


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
    assert {"batches", "processes", "cost"} <= set(checkup.unchecked)


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
def test_a_problem_that_hangs_costs_a_verdict(monkeypatch):
    values = replace(find_rule("values", "problem"), seconds=1.0)
    with closing(Checker(ProblemSubject(faulty_problems.Hanging))) as checking:
        assert "did not end within 1 s" in checking.verdict(values).finding


def test_every_verdict_on_a_sound_problem_is_passed_on():
    heard = []
    checkup = check_problem("engineering-spring", on_check=heard.append)
    assert checkup.passed
    assert heard == list(checkup)
    assert checkup.summary == "engineering-spring keeps the contract"


def test_untrusted_problems_are_given_by_name():
    with pytest.raises(BenchError, match="code that nobody trusts is checked by its name"):
        check_problem(faulty_problems.Sound(), untrusted=True)
