"""The problem family of the authors' recordings: ``published-03`` … ``published-13`` and ``published:low-1-12``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from problems.backlash.published.names import CLEAN
from problems.backlash.signature.families import check_options

if TYPE_CHECKING:
    from problems.backlash.signature.problem import SignatureFit


class _Published:
    """The family of the authors' recordings: listed without noise, and the noisy ones as ``published:low-1-12``."""

    def names(self) -> list[str]:
        return [f"published-{level:02d}" for level in CLEAN]

    def load(self, name: str, /, **options: Any) -> SignatureFit:
        check_options(name, options)
        from problems.backlash.published.recordings import published
        from problems.backlash.signature.problem import SignatureFit

        made = published(name)
        return SignatureFit(name, made.recording, peak=made.peak, half_gap=made.half_gap, **options)


published = _Published()
