"""The blocks of a study's problems: problems that resemble each other, and so count once for claims on further ones."""

from __future__ import annotations

import re
from collections.abc import Collection

from bench.errors import BenchError, nearest
from bench.families import function_of
from bench.study.values import Value


class Blocks(Value):
    """The block of each problem by label, or "function", by which the dimensions of a function are one block."""

    plain: str | dict[str, str]

    @classmethod
    def read(cls, value: object, what: str) -> Blocks:
        """Return the blocks of "function", or of a table of the block of each problem by label.

        ``what`` is the subject of a sentence about them.

        Raises:
            BenchError: for anything else.
        """
        if isinstance(value, Blocks):
            return value
        if value == "function":
            return cls("function")
        if isinstance(value, dict) and value and all(isinstance(each, str) and each for each in value.values()):
            return cls({str(label): each for label, each in value.items()})
        raise BenchError(
            f"{what} must be 'function', by which the dimensions of a function are one block, or a table with the "
            f"block of each problem by its label, such as {{f1-d10 = 'f1', f1-d20 = 'f1'}}, not {value!r}"
        )

    def of(self, label: str) -> str:
        """Return the block of a problem; "" where there is none."""
        if isinstance(self.plain, str):
            return re.sub(r"(-[di][0-9]+)+$", "", label)
        return self.plain.get(label, next((of for each, of in self.plain.items() if function_of(each) == label), ""))

    def within(self, labels: Collection[str]) -> Blocks | None:
        """Return the blocks of these problems alone; None where they have none."""
        if isinstance(self.plain, str):
            return self
        kept = {label: block for label, block in self.plain.items() if label in labels}
        return Blocks(kept) if kept else None

    def require_known(self, labels: Collection[str], where: str) -> None:
        """Raise BenchError where a label of the table is none of these; ``where`` begins the sentence."""
        for label in self.plain if isinstance(self.plain, dict) else ():
            if label not in labels:
                raise BenchError(f"{where}'blocks' names {label!r}, which is no problem{nearest(label, labels)}")
