"""Check an optimizer or a problem: the rules of its contract, in a process of its own; and biases of an optimizer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from typing import TypeVar

from bench.check.conformance.problem_subject import ProblemSubject
from bench.check.conformance.recording import LOST, explain_lost_process
from bench.check.conformance.rules import APART, RULES, SEARCH, TABLES, Rule, failed, find_rule, judge
from bench.check.conformance.single import PRINTED
from bench.check.conformance.subject import START_SECONDS, AnySubject, Subject, pack, unpack
from bench.check.verdict import LONGEST, Checkup, Verdict
from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.contract.typing import Options
from bench.execution.job import MEMORY, sandbox, sandbox_of_optimizers
from bench.helpers.errors import BenchError
from bench.helpers.text import printable
from bench.sandbox.bubblewrap import Sandbox
from bench.sandbox.messages import describe_error
from bench.sandbox.process import Process, RemoteError

Examined = TypeVar("Examined", bound=AnySubject)


def check_optimizer(
    optimizer: str | type[Optimizer] | Optimizer,
    /,
    *,
    bias: bool = True,
    untrusted: bool = False,
    n_jobs: int = -1,
    seed: int = 0,
    on_check: Callable[[Verdict], None] | None = None,
    **options: object,
) -> Checkup:
    """Check that an optimizer keeps the contract, and look for biases of its method.

    The optimizer runs in separate processes, so that hanging, printing or crashing costs a verdict and nothing else.

    Example:
        >>> assert bench.check_optimizer(HillClimber, bias=False)
        >>> print(bench.check_optimizer("gwo", agents=300))

    Args:
        optimizer: a name (``"gwo"``, ``"mealpy:OriginalGWO"``, ``"path/file.py:Class"``), a class or an instance.
        bias: whether to look for biases too; they are only looked for where ordinary runs keep the contract.
        untrusted: whether to run the optimizer, given by name, in a sandbox of bubblewrap alone (Linux), and to compare
            a run with one whose problem is in another process, which finds an optimizer that spends more evaluations
            than it is given or gets values by another way than the objective.
        n_jobs: processes that look for biases, -1 for one a core.
        seed: of the runs; the same one gives the same verdicts.
        on_check: called with every verdict as soon as it is known.
        options: parameters, for a name or a class; give an instance for a parameter named like an argument above.

    Raises:
        BenchError: for an unknown name or parameter, a value out of its range, or an argument that is not an optimizer.
    """
    subject, apart = _prepared(Subject, optimizer, options, seed, untrusted)
    return _checkup(subject, _verdicts(subject, bias, n_jobs, apart), on_check)


def check_problem(
    problem: str | type[Problem] | Problem,
    /,
    *,
    search: bool = False,
    untrusted: bool = False,
    seed: int = 0,
    on_check: Callable[[Verdict], None] | None = None,
    **options: object,
) -> Checkup:
    """Check that a problem keeps the contract: its values, its box and repair, its claims.

    The problem is asked in separate processes, so that hanging, printing or crashing costs a verdict and nothing else.

    Example:
        >>> assert bench.check_problem("signature-12")

    Args:
        problem: a name (``"signature-12"``, ``"path/file.py:Mine"``), a class or an instance.
        search: whether CMA-ES and L-SHADE shall also try to get below the claimed optimum, with 20,000 evaluations for
            every variable: minutes.
        untrusted: whether to load the problem, given by name, in a sandbox of bubblewrap alone (Linux).
        seed: of the points; the same one gives the same verdicts.
        on_check: called with every verdict as soon as it is known.
        options: of the problem, for a name or a class; give an instance for an option named like an argument above.

    Raises:
        BenchError: for an unknown name or option, and for an argument that is no problem.
    """
    subject, apart = _prepared(ProblemSubject, problem, options, seed, untrusted)
    rules = (*TABLES["problem"], SEARCH) if search else TABLES["problem"]
    with closing(Checker(subject, apart)) as checker:
        return _checkup(subject, filter(None, map(checker.verdict, rules)), on_check)


def _prepared(
    kind: type[Examined], plugin: object, options: Options, seed: int, untrusted: bool
) -> tuple[Examined, Sandbox | None]:
    """Return the subject of a check, made here once unless nobody trusts its code, and the sandbox for it, if any."""
    if not untrusted:
        return kind.of(plugin, options, seed), None
    if not isinstance(plugin, str):
        raise BenchError("code that nobody trusts is checked by its name, such as path/to/file.py:Mine")
    apart = sandbox([plugin]) if kind is ProblemSubject else sandbox_of_optimizers([plugin])
    return kind(plugin, options, seed), apart


def _checkup(subject: AnySubject, verdicts: Iterator[Verdict], on_check: Callable[[Verdict], None] | None) -> Checkup:
    """Return all verdicts, each of which is passed on as soon as it is known."""
    made: list[Verdict] = []
    for verdict in verdicts:
        made.append(verdict)
        if on_check is not None:
            on_check(verdict)
    checked = {verdict.check for verdict in made}
    left = tuple(rule.name for rule in TABLES[subject.kind] if rule.name not in checked)
    return Checkup(subject.label, tuple(made), left)


def _verdicts(subject: Subject, bias: bool, n_jobs: int, apart: Sandbox | None) -> Iterator[Verdict]:
    """Yield the verdicts on all rules that can be checked, and on biases where ordinary runs keep the contract."""
    rules = [*RULES, *([APART] if apart else [])]
    with closing(Checker(subject, apart)) as checker:
        kept = set()
        for verdict in filter(None, map(checker.verdict, rules)):
            yield verdict
            if verdict.passed:
                kept.add(verdict.check)
    if not (bias and {"run", "budget"} <= kept):
        return
    from bench.check.bias import diagnose  # not at the top: it imports scipy.stats and joblib

    try:
        yield from diagnose(subject if apart else subject.fresh(), n_jobs=n_jobs, seed=subject.seed, sandbox=apart)
    except Exception as error:  # a plug-in may raise anything, and its other verdicts stand
        finding = f"it could not be examined: {describe_error(error)}"
        yield Verdict("bias", "bias", False, finding, "fix what raises on ordinary functions of seven variables")


class Checker:
    """Check an optimizer or a problem against rules, each at most once, and none before the rules that it needs.

    A process starts with the first verdict, and a new one after the plug-in has hung, ended or upset it. In a sandbox
    the plug-in is constructed there alone, and BenchError is raised where that is refused.

    Attributes:
        unloadable: why no other process can load the plug-in, so that no rule can be checked; "" where one can.
    """

    def __init__(self, subject: AnySubject, apart: Sandbox | None = None) -> None:
        self.unloadable = ""
        self._subject, self._sandbox = subject, apart
        self._memory = MEMORY if apart else None
        self._verdicts: dict[str, Verdict | None] = {}
        self._packed = b""
        self._process: Process | None = None

    def verdict(self, rule: Rule) -> Verdict | None:
        """Return the verdict on the rule, None where it cannot be checked."""
        if rule.name not in self._verdicts:
            needed = [self.verdict(need) for need in self._needs(rule)]
            kept = all(verdict is not None and verdict.passed for verdict in needed)
            self._verdicts[rule.name] = self._judge(rule) if kept else None
            if self.unloadable and rule.name == "pickling":
                self._verdicts[rule.name] = failed(rule, self.unloadable)
        return self._verdicts[rule.name]

    def obstacle(self, rule: Rule) -> Rule:
        """Return the broken rule because of which this one cannot be checked."""
        for need in self._needs(rule):
            verdict = self.verdict(need)
            if verdict is not None and not verdict.passed:
                return need
        return TABLES[self._subject.kind][0]

    def _needs(self, rule: Rule) -> list[Rule]:
        return [find_rule(name, self._subject.kind) for name in rule.needs]

    def close(self) -> None:
        """End the process; a later verdict starts a new one."""
        if self._process is not None:
            self._process.close()
        self._process = None

    def _judge(self, rule: Rule) -> Verdict | None:
        """Return the verdict of the process on the rule, None where there is nothing to examine."""
        process = self._process or self._start()
        if process is None:
            return None
        try:
            limits: dict[str, object] = {"seconds": rule.seconds, "memory": self._memory, "printed": PRINTED}
            answer = process.call(_judge, self._packed, rule.name, **limits)
            return None if answer is None else _read(rule, answer)
        except ValueError:
            verdict = failed(rule, "its process gave an answer that is no verdict", "leave the harness's objects alone")
        except RemoteError as error:  # such as KeyboardInterrupt; other exceptions are in the verdict
            verdict = failed(rule, f"it raised {error}")
        except LOST as error:
            verdict = failed(rule, *explain_lost_process(error, process.note))
        self.close()
        return verdict

    def _start(self) -> Process | None:
        """Return a process that has loaded the plug-in, None where none can."""
        if not self._packed and not self.unloadable:
            try:
                self._packed = pack(self._subject)
            except Exception as error:  # the parameters of a plug-in may raise anything
                self.unloadable = f"it cannot be sent to another process: {describe_error(error)}"
        if not self.unloadable:
            self._process = Process(hash_seed=0, sandbox=self._sandbox)
            try:
                limits: dict[str, object] = {"seconds": START_SECONDS, "memory": self._memory, "printed": PRINTED}
                refused = self._process.call(_load, self._packed, self._sandbox is not None, **limits)
                if isinstance(refused, str):
                    raise BenchError(printable(refused, LONGEST))
            except (RemoteError, *LOST) as error:
                self.close()
                self.unloadable = f"another process cannot load it: {error}"
        return self._process


def _load(packed: bytes, construct: bool) -> str | None:
    """Load the plug-in; where it was not constructed before, return why it cannot be, None where it can."""
    subject = unpack(packed)
    with suppress(Exception):  # the rule of the parameters reports it
        try:
            if construct:
                subject.fresh()
        except BenchError as error:
            return str(error)
    return None


def _judge(packed: bytes, name: str) -> dict[str, object] | None:
    subject = unpack(packed)
    verdict = judge(find_rule(name, subject.kind), subject)
    return None if verdict is None else verdict.as_dict()


def _read(rule: Rule, answer: object) -> Verdict:
    """Return the verdict that a process gave; raises ValueError for what is no verdict on this rule."""
    verdict = Verdict.from_dict(answer)
    if (verdict.check, verdict.kind) != (rule.name, "conformance"):
        raise ValueError("a verdict on another rule")
    return verdict
