"""The conformance suite: every fault fails its own check and no other, and what is sound passes all."""

import subprocess
import sys
from dataclasses import dataclass
from textwrap import dedent

import pytest

import bench
from bench import BenchError, load_optimizer
from bench.check import check_optimizer, suite
from bench.check.conformance import checker
from bench.check.conformance.checker import check_conformance, each_verdict
from bench.check.conformance.rules import RULES, judge
from bench.check.conformance.subject import Subject, make_subject, pack, unpack
from bench.check.verdict import Verdict
from tests.bench.check import faulty

ALL = {rule.name for rule in RULES}
IN_ONE_PROCESS = [rule for rule in RULES if rule.name != "processes"]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Some of the faulty ones leave files."""
    monkeypatch.chdir(tmp_path)


def verdicts(optimizer, rules=IN_ONE_PROCESS, **options):
    """The verdicts by check, made in this process."""
    subject = make_subject(optimizer, options, seed=0)
    return {verdict.check: verdict for verdict in each_verdict(lambda rule: judge(rule, subject), rules)}


def failures(found):
    return [verdict for verdict in found.values() if not verdict.passed]


FAULTS = [
    (faulty.Thawed, "parameters", "Thawed is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Plain, "parameters", "Plain is no frozen dataclass", "@dataclass(frozen=True)"),
    (faulty.Undecorated, "parameters", "'step' of Undecorated looks like a parameter", "above Undecorated too"),
    (faulty.Greedy, "parameters", "takes anything as 'step'", "call super().__post_init__()"),
    (faulty.Hasty, "parameters", "a wrong 'step' raises TypeError", "before anything else"),
    (faulty.Empty, "parameters", "it takes agents=0", "bench.parameter(30, minimum=1)"),
    (faulty.Demanding, "parameters", "'step' has no default", "a default"),
    (faulty.Abstract, "parameters", "no method minimize", "write minimize"),
    (faulty.Misfit, "parameters", "BenchError: parameter 'step' of Misfit must be a whole number", "that fit"),
    (faulty.Broken, "run", "it raised ZeroDivisionError: by zero", "mend what raises"),
    (faulty.Idle, "run", "without a single evaluation", "ask objective(x)"),
    (faulty.Stubborn, "budget", "2 more times after the budget of 1 was spent", "let BudgetExhausted pass"),
    (faulty.Rounding, "budget", "without a single evaluation of a budget of 1", "below one generation"),
    (faulty.Clocked, "repetition", "two runs of one seed differ (from evaluation 5 on)", "draw from rng alone"),
    (faulty.Counting, "repetition", "two runs of one seed differ", "kept in the module"),
    (faulty.Remembering, "no state", "a second run of one instance differs from that of a new one", "local variables"),
    (faulty.Adapting, "no state", "changes its parameter 'step' from 0.1 to 0.2", "local variables"),
    (faulty.Locked, "pickling", "TypeError: cannot pickle '_thread.lock' object", "plain values"),
    (faulty.Legacy, "global states", "changes the global random state of numpy.random", "draw from rng alone"),
    (faulty.Peeking, "global states", "depends on the global random states", "draw from rng alone"),
    (faulty.Escaping, "box", "lie outside the box, such as [", "clip to objective.lower"),
    (
        faulty.Planar,
        "dimensions",
        "IndexError: index 1 is out of bounds for axis 1 with size 1 in 1 dimension",
        "any dimension",
    ),
    (faulty.Finite, "values", "it raised ValueError: autodetected range of", "+inf can occur"),
    (faulty.Ranging, "values", "points that are not finite with equal values", "guard divisions"),
    (faulty.Content, "values", "returned after 4 of 150 evaluations with equal values", "objective.stop"),
    (faulty.Spying, "contract", "it reads or sets _problem of the objective", ".initial(n)"),
    (faulty.Boasting, "contract", "it reads or sets best_value of the objective", ".initial(n)"),
    (faulty.Stretching, "contract", "it reads or sets upper of the objective", ".initial(n)"),
    (
        faulty.Knowing,
        "anonymity",
        "depends on the problem's name, variables or known optimum",
        "nothing of the problem",
    ),
    (faulty.Chatty, "silence", "such as 'generation ", "print and log nothing"),
    (faulty.Loud, "silence", "such as 'iterating'", "print and log nothing"),
    (faulty.Littering, "leftovers", "1 file in the working folder, such as 'outwalker.log'", "write no files"),
]


@pytest.mark.parametrize(
    ("optimizer", "check", "finding", "mend"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_fails_its_own_check_alone_and_says_how_to_mend_it(optimizer, check, finding, mend):
    found = failures(verdicts(optimizer))
    assert [verdict.check for verdict in found] == [check]
    assert finding in found[0].finding
    assert mend in found[0].mend
    assert "\n" not in found[0].finding


@pytest.mark.parametrize("optimizer", [faulty.Hashing, faulty.Foreign])
def test_a_run_that_depends_on_its_process_is_found(optimizer):
    found = failures(verdicts(optimizer, RULES))
    assert [verdict.check for verdict in found] == ["processes"]
    assert "another run in another process" in found[0].finding
    assert "do not loop over a set" in found[0].mend


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
        (faulty.Crashing, "dimensions", "ended the process that it ran in (", "crash in compiled code"),
        (faulty.Threaded, "leftovers", "every run leaves a thread running", "in a finally"),
    ],
)
def test_what_hangs_crashes_or_spoils_its_process_costs_its_own_check_alone(optimizer, check, finding, mend):
    found = {verdict.check: verdict for verdict in check_conformance(Subject(optimizer), haste=15)}
    assert [verdict.check for verdict in failures(found)] == [check]
    assert finding in found[check].finding
    assert mend in found[check].mend
    assert found.keys() == ({"parameters", "run"} if check == "run" else ALL)


@pytest.mark.parametrize("name", ["random-search", "gwo", "alo", "goa", "da", "cma-es"])
def test_built_ins_conform(name):
    found = verdicts(name, RULES)
    assert not failures(found)
    assert found.keys() == ALL


@pytest.mark.parametrize(
    ("optimizer", "check", "finding"),
    [
        (faulty.Sound, "repetition", "a seed repeats its run, other seeds give others"),
        (faulty.Deterministic, "repetition", "deterministic: "),
        (faulty.Pattern, "repetition", "other seeds give others; nothing is drawn from rng"),
        (faulty.Tired, "budget", "stopped early and declared: tired"),
        (faulty.Careful, "budget", "kept budgets of 1, 2, 6, 1000 to the evaluation"),
        (faulty.Outdated, "silence", "nothing printed; warned: UserWarning: deprecated"),
    ],
)
@pytest.mark.filterwarnings("ignore:deprecated")
def test_a_sound_optimizer_passes_whatever_its_ways(optimizer, check, finding):
    found = verdicts(optimizer)
    assert not failures(found)
    assert finding in found[check].finding


def test_whether_the_problem_s_own_repair_is_used_is_told_and_not_judged():
    assert "all points are feasible" in verdicts("random-search")["repair"].finding
    assert "% of the points are infeasible" in verdicts("random-search", handling="box")["repair"].finding


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
        "Clocked fails the contract in: repetition; not checked before that is mended: "
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


def test_a_class_of_a_file_is_checked_under_its_relative_name(tmp_path):
    (tmp_path / "mine.py").write_text(
        "def search(objective, rng, n=3):\n    while True: objective(objective.initial(n))\n"
    )
    found = verdicts("mine.py:search")
    assert not failures(found)
    made = load_optimizer("mine.py:search", n=2)
    assert make_subject(made, {}, 0) == Subject("mine.py:search", {"n": 2})
    assert make_subject(type(made), {}, 0) == Subject("mine.py:search")


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


def test_an_instance_is_checked_with_its_parameters():
    optimizer = faulty.Sound(agents=2, way="near")
    packed = pack(make_subject(optimizer, {}, 3))
    assert unpack(packed) == Subject(optimizer, {}, 3, packed)
    assert "kept budgets of 1, 2, 3, 9, 1000" in verdicts(optimizer)["budget"].finding


def test_a_copy_of_another_class_is_found():
    found = failures(verdicts(faulty.Changeling))
    assert [verdict.check for verdict in found] == ["pickling"]
    assert found[0].finding == "its pickled copy is a Sound, not a Changeling"


def test_a_copy_that_loses_a_parameter_is_found():
    found = failures(verdicts(faulty.Forgetful, step=0.3))
    assert [verdict.check for verdict in found] == ["pickling"]
    assert found[0].finding == "its pickled copy has other parameters"


def test_an_instance_that_cannot_be_pickled_is_told_so():
    checkup = check_optimizer(faulty.Locked(), bias=False)
    assert [(verdict.check, verdict.passed) for verdict in checkup] == [("pickling", False)]
    assert "it cannot be sent to another process: TypeError: cannot pickle" in checkup.verdicts[0].finding


def test_a_class_that_no_other_process_can_load_is_told_so(monkeypatch):
    monkeypatch.setattr(checker, "pack", lambda subject: b"nothing of the kind")
    checkup = check_optimizer(faulty.Sound, bias=False)
    assert [(verdict.check, verdict.passed) for verdict in checkup] == [("pickling", False)]
    assert "another process cannot load it: UnpicklingError" in checkup.verdicts[0].finding


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


def test_a_process_that_dies_while_it_loads_is_told(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(
        "import os\nif 'PYTHONIOENCODING' in os.environ: os._exit(9)\ndef go(f, rng): ..."
    )
    monkeypatch.delenv("PYTHONIOENCODING", raising=False)
    checkup = check_optimizer("mine.py:go", bias=False)
    assert checkup.summary.startswith("mine.py:go fails the contract in: parameters")
    assert "ended the process that it ran in (exit code 9)" in checkup.verdicts[0].finding


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


def test_an_interrupt_is_the_user_s(monkeypatch):
    @dataclass(frozen=True)
    class Interrupted(faulty.Walker):
        def move(self, x, f, objective, rng):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        verdicts(Interrupted)
