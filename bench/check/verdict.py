"""The outcome of one check of an optimizer."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal


@dataclass(frozen=True)
class Verdict:
    """The outcome of one check of an optimizer.

    Attributes:
        check: what was checked, such as ``"budget"`` or ``"centre bias"``.
        kind: ``"conformance"`` to the contract, which is required of every optimizer; or ``"bias"``, a
            property of the method that readers of a comparison must know, and no error of the plug-in.
        passed: whether the optimizer conforms, or is free of the bias.
        finding: one sentence on what was observed.
        mend: how to mend it, "" where the check passed.
        figure: the number that decided the outcome, where there is one.
    """

    check: str
    kind: Literal["conformance", "bias"]
    passed: bool
    finding: str
    mend: str = ""
    figure: float | None = None

    @property
    def outcome(self) -> str:
        """One word: ``"passed"``, ``"FAILED"`` for a breach of the contract, ``"BIASED"`` for a bias of the method."""
        return "passed" if self.passed else "FAILED" if self.kind == "conformance" else "BIASED"

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict as a dict for JSON."""
        return asdict(self)
