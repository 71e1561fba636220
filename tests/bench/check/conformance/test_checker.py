"""Rules are checked once, in order and in a process of their own, whatever the optimizer does to the process."""

from contextlib import closing
from dataclasses import replace

import pytest

from bench.check import check_optimizer
from bench.check.conformance import checker
from bench.check.conformance.checker import PICKLING, Checker
from bench.check.conformance.rules import RULES, failed, find_rule
from bench.check.conformance.subject import Subject
from bench.check.verdict import Verdict
from tests.bench.check import faulty
from tests.bench.check.conformance.examine import ALL, failures

HURRIED = {faulty.Hanging: 8.0, faulty.Stuck: 2.0}  # seconds, where the check would wait for its whole patience


@pytest.mark.parametrize(
    ("optimizer", "check", "finding", "mend"),
    [
        (
            faulty.Cached,
            "processes",
            "another run in another process, after other runs",
            "or the class from run to run",
        ),
        (faulty.Endless, "run", "for ever after its budget of 150 is spent", "let BudgetExhausted pass"),
        (faulty.Hanging, "run", "did not end within 8 s after its budget of 150 was spent", "let BudgetExhausted pass"),
        (faulty.Stuck, "box", "it asked for no value for 2 s, after 0 evaluations", "never calls the objective"),
        (faulty.Quitting, "values", "ended the process that it ran in (exit code 3)", "raise an exception"),
        (faulty.Interrupting, "dimensions", "it raised KeyboardInterrupt: no message", "any dimension"),
        (faulty.Crashing, "dimensions", "ended the process that it ran in (", "crash in compiled code"),
        (faulty.Threaded, "leftovers", "every run leaves a thread running", "in a finally"),
    ],
)
def test_what_hangs_crashes_or_spoils_its_process_costs_its_own_check_alone(optimizer, check, finding, mend):
    patience = HURRIED.get(optimizer, find_rule(check).patience)
    rules = [replace(rule, patience=patience) if rule.name == check else rule for rule in RULES]
    with closing(Checker(Subject(optimizer))) as checker:
        found = {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}
    assert [verdict.check for verdict in failures(found)] == [check]
    assert finding in found[check].finding
    assert mend in found[check].mend
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
    assert len([*filter(None, map(checker.verdict, RULES))]) == 16


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
    assert unsendable.verdict(PICKLING).finding == unsendable.unloadable
    assert len(asked) == 1
