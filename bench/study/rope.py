"""The region of practical equivalence (rope) of a study: differences that are too small to matter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bench.errors import BenchError
from bench.study.values import Value
from bench.typing import Floats


@dataclass(frozen=True, eq=False, repr=False)
class Rope(Value):
    """The difference of two medians up to which they count as equal.

    Attributes:
        number: in the unit of the objective, or a percentage of the smaller size of the two medians.
        relative: whether it is a percentage.
    """

    number: float
    relative: bool

    @classmethod
    def read(cls, value: object, what: str) -> Rope:
        """Return the rope of a positive number, of a percentage below 100 such as ``"1%"``, or of a text of either.

        ``what`` is the subject of a sentence about it, such as ``"the rope"``.

        Raises:
            BenchError: for anything else.
        """
        if isinstance(value, Rope):
            return value
        text, relative = str(value).strip(), isinstance(value, str) and value.strip().endswith("%")
        try:
            number = math.nan if isinstance(value, bool) else float(text.removesuffix("%") if relative else text)
        except ValueError:
            number = math.nan
        if not 0 < number < (100 if relative else math.inf):
            raise BenchError(
                f"{what} must be a positive width in the unit of the objective, such as 0.5, or a percentage of the "
                f"values below 100, such as '1%', not {value!r}"
            )
        return cls(number, relative)

    @property
    def plain(self) -> float | str:
        """The number, or the text of the percentage."""
        return f"{self.number:.12g}%" if self.relative else self.number

    @property
    def words(self) -> str:
        """The rope in words, such as ``"0.5"`` or ``"1%"``."""
        return str(self.plain) if self.relative else f"{self.number:g}"

    def widths(self, first: Floats, second: Floats) -> Floats:
        """Return the rope in the unit of the objective beside medians, (n,) each; 0 beside infinite ones."""
        if not self.relative:
            return np.full(len(first), self.number)
        size = np.minimum(np.abs(first), np.abs(second))
        return np.asarray(self.number / 100 * np.where(np.isfinite(size), size, 0.0))
