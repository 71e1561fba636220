"""``check_optimizer``: its report, what it accepts, and when it looks for biases."""

import subprocess
import sys
from textwrap import dedent

import pytest

import bench
from bench import BenchError, load_optimizer
from bench.check import check_optimizer, suite
from bench.check.conformance.rules import RULES
from bench.check.verdict import Verdict
from tests.bench.check import faulty


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
    assert checkup.unchecked == ("processes", "no state", "pickling", "global states", "anonymity")
    text = str(checkup)
    assert "  FAILED  repetition" in text
    assert "mend: draw from rng alone" in text
    assert text.endswith(
        "Clocked fails the contract in: repetition; not checked until that is mended: "
        "processes, no state, pickling, global states, anonymity"
    )


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
            assert len(checkup.verdicts) == 16, str(checkup)
            """
        )
    )
    subprocess.run([sys.executable, script], check=True, timeout=300, cwd=tmp_path)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: check_optimizer("no/such/file.py:Mine"), "the optimizer file no/such/file.py cannot be read"),
        (lambda: check_optimizer("gwp"), "unknown optimizer 'gwp'; did you mean 'gwo'?"),
        (lambda: check_optimizer("gwo", agentss=3), "no parameter 'agentss'; did you mean 'agents'?"),
        (lambda: check_optimizer(faulty.Sound(), agents=3), "'agents' cannot be set: the optimizer is made already"),
        (
            lambda: check_optimizer(3),
            "give the name of an optimizer, an Optimizer subclass or an instance of one, not 3",
        ),
        (lambda: check_optimizer("gwo", seed=-1), "the seed must be a whole number of at least 0, not -1"),
        (lambda: check_optimizer(int), "not <class 'int'>"),
        (lambda: check_optimizer(faulty.Sound, agentss=3), "no parameter 'agentss'; did you mean 'agents'?"),
        (lambda: check_optimizer(faulty.Sound, agents=0), "'agents' of Sound must be at least 1, not 0"),
    ],
)
def test_what_cannot_be_checked_at_all_is_refused_in_a_sentence(call, said):
    with pytest.raises(BenchError) as caught:
        call()
    assert said in str(caught.value)


@pytest.fixture
def conforming(monkeypatch):
    """Spare the checks of the contract."""
    made = [Verdict(rule.name, "conformance", True, "well") for rule in RULES]
    monkeypatch.setattr(suite, "check_conformance", lambda subject: iter(made))
    return made


def test_biases_are_looked_for_with_the_optimizer_s_own_parameters(conforming, monkeypatch):
    asked = []

    def diagnose(optimizer, *, n_jobs, seed):
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
    def diagnose(optimizer, *, n_jobs, seed):
        raise RuntimeError("no noise today")

    monkeypatch.setattr("bench.check.bias.diagnose", diagnose)
    checkup = check_optimizer("gwo")
    assert checkup.verdicts[-1].kind == "bias"
    assert checkup.verdicts[-1].finding == "it could not be examined: RuntimeError: no noise today"


def test_an_optimizer_that_cannot_keep_its_budget_is_not_searched_for_biases(monkeypatch):
    monkeypatch.setattr("bench.check.bias.diagnose", lambda *_, **__: pytest.fail("was asked"))
    assert not check_optimizer(faulty.Idle)
