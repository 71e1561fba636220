"""The blocks of a study's problems: problems that resemble each other, and so count once for claims on further ones."""

from __future__ import annotations

import re
from typing import Any

from bench.errors import BenchError

Blocks = str | dict[str, str]
"""As a study holds them: "function", or the block of each problem by label."""


def checked(value: Any, what: str) -> Blocks:
    """Return blocks as a study holds them: "function", or a table of the block of each problem by label.

    Args:
        value: of the study.
        what: the subject of a sentence about it.

    Raises:
        BenchError: for anything else.
    """
    if value == "function":
        return "function"
    if isinstance(value, dict) and value and all(isinstance(each, str) and each for each in value.values()):
        return {str(label): each for label, each in value.items()}
    raise BenchError(
        f"{what} must be 'function', by which the dimensions of a function are one block, or a table with the block of "
        f"each problem by its label, such as {{f1-d10 = 'f1', f1-d20 = 'f1'}}, not {value!r}"
    )


def pooled(label: str) -> str:
    """Return the label of a problem without its instance, as reports name it."""
    return re.sub(r"-i[0-9]+$", "", label)


def block(blocks: Blocks | None, label: str) -> str:
    """Return the declared block of a problem; "" where there is none."""
    if isinstance(blocks, dict):
        return blocks.get(label, next((of for each, of in blocks.items() if pooled(each) == label), ""))
    return re.sub(r"(-[di][0-9]+)+$", "", label) if blocks else ""
