"""Check an optimizer against the rules of the contract, in a process of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing

from bench.check.conformance.rules import RULES, Rule, failed, find_rule, judge
from bench.check.conformance.subject import START_PATIENCE, Subject, pack, unpack
from bench.check.conformance.violation import explain_lost_process
from bench.check.verdict import Verdict
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError, Process, Pulse, RemoteError, SilentError

CONSTRUCTION, PICKLING = find_rule("parameters"), find_rule("pickling")

Judge = Callable[[Rule], Verdict | None]


class UnloadableError(Exception):
    """No other process can load the optimizer, so that no rule can be checked; the message is a finding."""


class Checker:
    """Check an optimizer against rules, each at most once, and none before the rules that it needs.

    Args:
        judge: returns the verdict on a rule, None where there is nothing to examine.
    """

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._verdicts: dict[str, Verdict | None] = {}

    def verdict(self, rule: Rule) -> Verdict | None:
        """Return the verdict on the rule, None where it cannot be checked; raises what the judge raises."""
        if rule.name not in self._verdicts:
            needed = [self.verdict(find_rule(name)) for name in rule.needs]
            kept = all(verdict is not None and verdict.passed for verdict in needed)
            self._verdicts[rule.name] = self._judge(rule) if kept else None
        return self._verdicts[rule.name]

    def obstacle(self, rule: Rule) -> Rule:
        """Return the broken rule because of which this one cannot be checked."""
        for need in map(find_rule, rule.needs):
            verdict = self.verdict(need)
            if verdict is not None and not verdict.passed:
                return need
        return CONSTRUCTION


class ProcessJudge:
    """Judge rules in another process, and in a new one after the optimizer has hung or ended it.

    The process starts with the first verdict.

    Args:
        subject: the optimizer.
    """

    def __init__(self, subject: Subject) -> None:
        self._subject = subject
        self._packed = b""
        self._process: Process | None = None
        self._unloadable = ""  # the finding on an optimizer that no other process can load

    def __call__(self, rule: Rule) -> Verdict | None:
        """Return the verdict on the rule, None where there is nothing to examine.

        Raises:
            UnloadableError: when no other process can load the optimizer.
        """
        self._process = process = self._process or self._start()
        try:
            verdict: Verdict | None = process.call(_judge, self._packed, rule.name, patience=rule.patience)
        except RemoteError as error:  # such as KeyboardInterrupt; other exceptions are in the verdict
            verdict = failed(rule, f"it raised {error}")
        except (SilentError, DiedError) as error:
            verdict = failed(rule, *explain_lost_process(error, process))
            self.close()
        return verdict

    def close(self) -> None:
        """End the process; a later verdict starts a new one."""
        if self._process is not None:
            self._process.close()
        self._process = None

    def _start(self) -> Process:
        """Return a process that has loaded the optimizer."""
        if not self._packed and not self._unloadable:
            try:
                self._packed = pack(self._subject)
            except Exception as error:  # the parameters of a plug-in may raise anything
                self._unloadable = f"it cannot be sent to another process: {describe_error(error)}"
        if not self._unloadable:
            process = Process(hash_seed=0)
            try:
                process.call(_load, self._packed, patience=START_PATIENCE)
                return process
            except (RemoteError, SilentError, DiedError) as error:
                process.close()
                self._unloadable = f"another process cannot load it: {error}"
        raise UnloadableError(self._unloadable)


def check_conformance(subject: Subject) -> Iterator[Verdict]:
    """Yield the verdicts on all rules that can be checked; see :class:`ProcessJudge`."""
    with closing(ProcessJudge(subject)) as ask:
        try:
            yield from each_verdict(ask)
        except UnloadableError as error:
            yield failed(PICKLING, str(error))


def each_verdict(judge: Judge, rules: Iterable[Rule] = RULES) -> Iterator[Verdict]:
    """Yield the verdicts on these rules, without those that cannot be checked."""
    yield from filter(None, map(Checker(judge).verdict, rules))


def _load(packed: bytes, pulse: Pulse) -> None:  # noqa: ARG001 - nothing to report
    unpack(packed)


def _judge(packed: bytes, name: str, pulse: Pulse) -> Verdict | None:
    return judge(find_rule(name), dataclasses.replace(unpack(packed), pulse=pulse, expendable=True))
