"""The outcomes of the checks of an optimizer or a problem."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from bench.helpers.text import html_table, printable

KINDS = ("conformance", "bias")
LONGEST = 4_000  # characters of a text


@dataclass(frozen=True)
class Verdict:
    """The outcome of one check of an optimizer or a problem.

    Attributes:
        check: what was checked, such as ``"budget"`` or ``"centre bias"``.
        kind: ``"conformance"`` to the contract, which is required of all; or ``"bias"``, a
            property of the method that readers of a comparison must know, and no error of the plug-in.
        passed: whether the plug-in conforms, or is free of the bias.
        finding: one sentence on what was observed.
        remedy: how to fix it, "" where the check passed.
        figure: the number that decided the outcome, where there is one.
    """

    check: str
    kind: Literal["conformance", "bias"]
    passed: bool
    finding: str
    remedy: str = ""
    figure: float | None = None

    @property
    def outcome(self) -> str:
        """The outcome in a word, ``"passed"``, ``"FAILED"`` for a broken rule, ``"BIASED"`` for a bias."""
        return "passed" if self.passed else "FAILED" if self.kind == "conformance" else "BIASED"

    def as_dict(self) -> dict[str, object]:
        """Return the verdict as a dict for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, record: object) -> Verdict:
        """Return the verdict of :meth:`as_dict`; raises ValueError for what is none, as plug-in code may have made it.

        Texts are made printable.
        """
        kinds: dict[str, Any] = {"check": str, "kind": str, "passed": bool, "finding": str, "remedy": str}
        kinds["figure"] = (int, float, type(None))
        if not isinstance(record, dict) or record.keys() != kinds.keys():
            raise ValueError("it lacks fields of a verdict, or has others")
        if not all(isinstance(record[key], kind) for key, kind in kinds.items()) or record["kind"] not in KINDS:
            raise ValueError("the fields of a verdict have other types")
        shown: dict[str, Any] = {
            key: printable(value, LONGEST) if isinstance(value, str) else value for key, value in record.items()
        }
        return cls(**shown)


@dataclass(frozen=True)
class Checkup:
    """The verdicts on one optimizer or problem; true where it conforms to the contract.

    Attributes:
        label: the plug-in's name.
        verdicts: one for each check, in order.
        unchecked: the rules that could not be checked, because the plug-in breaks a rule that they need.
    """

    label: str
    verdicts: tuple[Verdict, ...]
    unchecked: tuple[str, ...] = ()

    @property
    def conforms(self) -> bool:
        """Whether the plug-in keeps the contract, biased or not."""
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
        left = f"; not checked until that is fixed: {', '.join(self.unchecked)}" if self.unchecked else ""
        biased = f"; biased: fails the checks of {failed['bias']}" if failed["bias"] else ""
        free = not biased and any(verdict.kind == "bias" for verdict in self.verdicts)
        return f"{self.label} {contract}{left}{biased}{'; no bias was found' if free else ''}"

    def __bool__(self) -> bool:
        return self.conforms

    def __iter__(self) -> Iterator[Verdict]:
        return iter(self.verdicts)

    def _repr_html_(self) -> str:
        """Return the verdicts as a table, for a notebook."""
        rows = [
            (
                verdict.check,
                verdict.outcome,
                f"{verdict.finding}; remedy: {verdict.remedy}" if verdict.remedy else verdict.finding,
            )
            for verdict in self.verdicts
        ]
        return html_table(self.summary, rows, ("check", "outcome", "finding"))

    def __str__(self) -> str:
        width = max((len(verdict.check) for verdict in self.verdicts), default=0)
        lines = [self.label]
        for verdict in self.verdicts:
            lines.append(f"  {verdict.outcome}  {verdict.check:{width}}  {verdict.finding}")
            if verdict.remedy:
                lines.append(f"  {'':6}  {'':{width}}  remedy: {verdict.remedy}")
        return "\n".join([*lines, self.summary])
