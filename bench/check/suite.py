"""Check an optimizer: the rules of the contract, in separate processes, and the biases of its method."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from bench.check.conformance.checker import check_conformance
from bench.check.conformance.rules import RULES
from bench.check.conformance.subject import Subject, make_subject
from bench.check.verdict import Verdict
from bench.optimizer import Optimizer
from bench.sandbox.messages import describe_error


@dataclasses.dataclass(frozen=True)
class Checkup:
    """The verdicts on one optimizer; true where it conforms to the contract.

    Attributes:
        label: the optimizer's name.
        verdicts: one for each check, in order.
        unchecked: the rules that could not be checked, because the optimizer breaks a rule that they need.
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
        """Whether it keeps the contract and no bias was found."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def summary(self) -> str:
        """One sentence on the outcome."""
        failed = {
            kind: ", ".join(verdict.check for verdict in self.verdicts if verdict.kind == kind and not verdict.passed)
            for kind in ("conformance", "bias")
        }
        contract = f"fails the contract in: {failed['conformance']}" if failed["conformance"] else "keeps the contract"
        left = f"; not checked until that is mended: {', '.join(self.unchecked)}" if self.unchecked else ""
        biased = f"; biased: fails the checks of {failed['bias']}" if failed["bias"] else ""
        free = not biased and any(verdict.kind == "bias" for verdict in self.verdicts)
        return f"{self.label} {contract}{left}{biased}{'; no bias was found' if free else ''}"

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
    on_check: Callable[[Verdict], None] | None = None,
    **options: Any,
) -> Checkup:
    """Check that an optimizer keeps the contract, and look for biases of its method.

    The optimizer runs in separate processes, so that hanging, printing or crashing costs a verdict and nothing else.

    Example:
        >>> assert bench.check_optimizer(HillClimber, bias=False)
        >>> print(bench.check_optimizer("gwo", agents=300))

    Args:
        optimizer: a name (``"gwo"``, ``"mealpy:OriginalGWO"``, ``"path/file.py:Class"``), a class or an instance.
        bias: whether to look for biases too; they are only looked for where ordinary runs keep the contract.
        n_jobs: processes that look for biases, -1 for one a core.
        seed: of the runs; the same one gives the same verdicts.
        on_check: called with every verdict as soon as it is known.
        options: parameters, for a name or a class; give an instance for a parameter named like an argument above.

    Raises:
        BenchError: for an unknown name or parameter, a value out of its range, or an argument that is no optimizer.
    """
    subject = make_subject(optimizer, options, seed)
    verdicts: list[Verdict] = []
    for verdict in _verdicts(subject, bias, n_jobs):
        verdicts.append(verdict)
        if on_check is not None:
            on_check(verdict)
    made = {verdict.check for verdict in verdicts}
    return Checkup(subject.label, tuple(verdicts), tuple(rule.name for rule in RULES if rule.name not in made))


def _verdicts(subject: Subject, bias: bool, n_jobs: int) -> Iterator[Verdict]:
    kept = set()
    for verdict in check_conformance(subject):
        yield verdict
        kept |= {verdict.check} if verdict.passed else set()
    if bias and {"run", "budget"} <= kept:
        yield from _biases(subject, n_jobs)


def _biases(subject: Subject, n_jobs: int) -> list[Verdict]:
    from bench.check.bias import diagnose

    try:
        return diagnose(subject.fresh(), n_jobs=n_jobs, seed=subject.seed)
    except Exception as error:  # a plug-in may raise anything, and its other verdicts stand
        finding = f"it could not be examined: {describe_error(error)}"
        return [Verdict("bias", "bias", False, finding, "mend what raises on ordinary functions of seven variables")]
