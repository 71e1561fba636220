"""The region of practical equivalence (rope) of a study: differences that are too small to matter."""

from __future__ import annotations

import math

import numpy as np

from bench.errors import BenchError
from bench.study.values import Value
from bench.typing import Floats


class Rope(Value):
    """The difference of two medians up to which they count as equal.

    Attributes:
        plain: a number in the unit of the objective, or the text of a percentage of the smaller size of the medians.
    """

    plain: float | str

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
        return cls(f"{number:.12g}%" if relative else number)

    @property
    def relative(self) -> bool:
        """Whether the rope is a percentage."""
        return isinstance(self.plain, str)

    @property
    def words(self) -> str:
        """The rope in words, such as ``"0.5"`` or ``"1%"``."""
        return self.plain if isinstance(self.plain, str) else f"{self.plain:g}"

    def widths(self, first: Floats, second: Floats) -> Floats:
        """Return the rope in the unit of the objective beside medians, (n,) each; 0 beside infinite ones."""
        if not isinstance(self.plain, str):
            return np.full(len(first), self.plain)
        size, share = np.minimum(np.abs(first), np.abs(second)), float(self.plain.removesuffix("%")) / 100
        return np.asarray(share * np.where(np.isfinite(size), size, 0.0))
