"""The conformance suite: every check of an optimizer in a process of its own, with a verdict and how to mend it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from bench.check.conformance import CHECKS, Check, each_check, failed, judge
from bench.check.fault import describe
from bench.check.searching import START
from bench.check.subject import Subject, make_subject, pack, unpack
from bench.check.verdict import Verdict
from bench.optimizer import Optimizer
from bench.sandbox.messages import describe_error
from bench.sandbox.process import DiedError, Process, Pulse, RemoteError, SilentError

PICKLING = next(check for check in CHECKS if check.name == "pickling")

Listener = Callable[[Verdict], None]


@dataclasses.dataclass(frozen=True)
class Checkup:
    """What the checks of one optimizer found; true where it conforms to the contract.

    Attributes:
        label: the optimizer's name.
        verdicts: one a check, in the order in which they were made.
        unchecked: the checks that could not be made, because one that they build on failed.
    """

    label: str
    verdicts: tuple[Verdict, ...]
    unchecked: tuple[str, ...] = ()

    @property
    def conforms(self) -> bool:
        """Whether the optimizer keeps the contract, biased or not."""
        return all(verdict.passed for verdict in self.verdicts if verdict.kind == "conformance")

    @property
    def passed(self) -> bool:
        """Whether it keeps the contract and is free of the biases that were looked for."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def summary(self) -> str:
        """One sentence on the outcome."""
        failed = {
            kind: [verdict.check for verdict in self.verdicts if verdict.kind == kind and not verdict.passed]
            for kind in ("conformance", "bias")
        }
        contract = f"fails the contract in: {', '.join(failed['conformance'])}"
        left = f"; not checked before that is mended: {', '.join(self.unchecked)}" if self.unchecked else ""
        biased = f"; biased: fails the checks of {', '.join(failed['bias'])}" if failed["bias"] else ""
        looked = any(verdict.kind == "bias" for verdict in self.verdicts)
        free = "; no bias was found" if looked and not biased else ""
        return f"{self.label} {'keeps the contract' if self.conforms else contract}{left}{biased}{free}"

    def __bool__(self) -> bool:
        return self.conforms

    def __iter__(self) -> Iterator[Verdict]:
        return iter(self.verdicts)

    def __str__(self) -> str:
        width = max((len(verdict.check) for verdict in self.verdicts), default=0)
        lines = [self.label]
        for verdict in self.verdicts:
            lines.append(f"  {verdict.outcome}  {verdict.check:{width}}  {verdict.finding}")
            if verdict.mend:
                lines.append(f"  {'':6}  {'':{width}}  mend: {verdict.mend}")
        return "\n".join([*lines, self.summary])


def check_optimizer(
    optimizer: str | type[Optimizer] | Optimizer,
    /,
    *,
    bias: bool = True,
    n_jobs: int = -1,
    seed: int = 0,
    on_check: Listener | None = None,
    **options: Any,
) -> Checkup:
    """Check that an optimizer keeps the contract, and look for biases of its method.

    It runs in processes of its own, so that one that hangs, prints or crashes costs a verdict and nothing else.

    Example:
        >>> assert bench.check_optimizer(HillClimber, bias=False)
        >>> print(bench.check_optimizer("gwo", agents=300))

    Args:
        optimizer: a name (``"gwo"``, ``"mealpy:OriginalGWO"``, ``"path/file.py:Class"``), a class or an instance.
        bias: whether to look for biases too; they are only looked for where ordinary runs keep the contract.
        n_jobs: processes that look for biases, -1 for one a core.
        seed: of the runs; the same one gives the same verdicts.
        on_check: called with every verdict as soon as it is there.
        options: parameters, for a name or a class; one that is called as an argument above goes into an instance.

    Raises:
        BenchError: for an unknown name or parameter, a value out of its range, or what is no optimizer.
    """
    subject = make_subject(optimizer, options, seed)
    verdicts: list[Verdict] = []

    def note(verdict: Verdict) -> None:
        verdicts.append(verdict)
        if on_check is not None:
            on_check(verdict)

    for verdict in conformance(subject):
        note(verdict)
    made = {verdict.check for verdict in verdicts}
    unchecked = tuple(check.name for check in CHECKS if check.name not in made)
    if bias and {"run", "budget"} <= {verdict.check for verdict in verdicts if verdict.passed}:
        for verdict in _biases(subject, n_jobs):
            note(verdict)
    return Checkup(subject.label, tuple(verdicts), unchecked)


def conformance(subject: Subject, haste: float = 1.0) -> Iterator[Verdict]:
    """Yield the verdicts of all checks that can be made; ``haste`` divides the time allowed without a sign of life."""
    try:
        packed = pack(subject)
    except Exception as error:  # what a stranger's parameters hold may raise anything
        yield failed(PICKLING, f"it cannot be sent to another process: {describe_error(error)}")
        return
    runner = _Runner(packed, haste)
    try:
        yield from each_check(runner.ask)
    except (RemoteError, SilentError, DiedError) as error:
        yield failed(PICKLING, f"another process cannot load it: {error}")
    finally:
        runner.close()


class _Runner:
    """Makes checks in one process, and in a new one after an optimizer has hung or ended it."""

    def __init__(self, packed: bytes, haste: float) -> None:
        self._packed, self._haste = packed, haste
        self._process: Process | None = None

    def ask(self, check: Check) -> Verdict | None:
        if self._process is None:
            self._process = Process(hash_seed=0)
            self._process.call(_load, self._packed, patience=START)
        try:
            verdict: Verdict | None = self._process.call(
                _judge, self._packed, check.name, patience=check.patience / self._haste
            )
        except (SilentError, DiedError) as error:
            verdict = failed(check, *describe(error, self._process))
            self.close()
        return verdict

    def close(self) -> None:
        if self._process is not None:
            self._process.close()
        self._process = None


def _load(packed: bytes, pulse: Pulse) -> None:  # noqa: ARG001 - nothing to report
    unpack(packed)


def _judge(packed: bytes, name: str, pulse: Pulse) -> Verdict | None:
    check = next(check for check in CHECKS if check.name == name)
    return judge(check, dataclasses.replace(unpack(packed), pulse=pulse, expendable=True))


def _biases(subject: Subject, n_jobs: int) -> list[Verdict]:
    from bench.check.bias import diagnose

    try:
        return diagnose(subject.fresh(), n_jobs=n_jobs, seed=subject.seed)
    except Exception as error:  # a plug-in may raise anything, and its other verdicts stand
        finding = f"it could not be examined: {describe_error(error)}"
        return [Verdict("bias", "bias", False, finding, "mend what raises on ordinary functions of seven variables")]
