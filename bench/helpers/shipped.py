"""Find files that the package carries: in its own folder where it is installed, beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def shipped(name: str, in_checkout: str) -> Path:
    """Return the folder ``name`` of an installed package, or that of a checkout, given from its root."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / in_checkout
