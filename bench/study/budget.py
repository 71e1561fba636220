"""The budget of a study: a number of evaluations, a multiple of the dimension ("1e4 * d"), or a number by dimension."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping

from bench.contract.numbers import LARGEST_BUDGET, is_whole, require_whole
from bench.helpers.errors import BenchError
from bench.helpers.text import joined
from bench.study.values import Value

_MULTIPLE = re.compile(r"\s*([0-9][0-9_]*(?:\.[0-9]+)?(?:[eE]\+?[0-9]+)?)\s*\*\s*d\s*", re.ASCII)


class Budget(Value, ABC):
    """The evaluations that a trial may spend."""

    @staticmethod
    def read(value: object, what: str = "the budget") -> Budget:
        """Return the budget of a plain value.

        Args:
            value: a whole number from 1 to 1e15; a text of one, or of a multiple of the dimension such as
                ``"1e4 * d"``; or a table of evaluations by dimension, such as ``{"10": 200_000, "20": 1_000_000}``.
            what: the subject of a sentence about it.

        Raises:
            BenchError: for anything else.
        """
        if isinstance(value, Budget):
            return value
        if isinstance(value, Mapping):
            for dimension, number in value.items():
                if not re.fullmatch(r"[1-9][0-9]{0,8}", str(dimension)):
                    raise BenchError(
                        f"{what} has a table of evaluations by dimension, but {dimension!r} is no dimension"
                    )
                require_whole(f"{what} at d = {dimension}", number, 1, LARGEST_BUDGET)
            if not value:
                raise BenchError(f"{what} is an empty table; give evaluations by dimension, such as {{10 = 200_000}}")
            return _Table({str(dimension): int(number) for dimension, number in value.items()})
        text = value.strip() if isinstance(value, str) else ""
        if _MULTIPLE.fullmatch(text) and 0 < (multiple := _Multiple(text)).factor <= LARGEST_BUDGET:
            return multiple
        number = int(text) if re.fullmatch(r"[0-9](_?[0-9]){0,30}", text, re.ASCII) else value
        if is_whole(number) and 1 <= number <= LARGEST_BUDGET:
            return _Same(int(number))
        raise BenchError(
            f"{what} must be a whole number from 1 to {LARGEST_BUDGET:g} or a multiple of the dimension such as "
            f"'1e4 * d', not {value!r}"
        )

    @property
    def number(self) -> int | None:
        """The evaluations in every dimension; None where they depend on it."""
        return self.plain if isinstance(self.plain, int) else None

    @abstractmethod
    def evaluations(self, dimension: int) -> int:
        """Return the evaluations on a problem of this dimension; raises BenchError where a table lacks it."""

    @property
    @abstractmethod
    def words(self) -> str:
        """The budget in words, such as ``"10,000 d evaluations"``."""

    def within(self, dimensions: Iterable[int | None]) -> Budget:  # noqa: ARG002 - of a table
        """Return the budget without dimensions other than these, where it is a table that has one of them."""
        return self

    def spent(self, most: Mapping[int | None, int]) -> Budget:
        """Return the budget of runs that spent at most these evaluations by dimension, of a kind with this one."""
        return _Same(max(most.values()))


class _Same(Budget):
    """As many evaluations in every dimension."""

    plain: int

    def evaluations(self, dimension: int) -> int:  # noqa: ARG002 - the same in all
        return self.plain

    @property
    def words(self) -> str:
        return f"{self.plain:,} evaluation{'' if self.plain == 1 else 's'}"


class _Multiple(Budget):
    """A multiple of the dimension, as its text."""

    plain: str

    @property
    def factor(self) -> float:
        return float(self.plain.partition("*")[0].replace("_", ""))

    def evaluations(self, dimension: int) -> int:
        return max(1, round(self.factor * dimension))

    @property
    def words(self) -> str:
        return f"{self.factor:,.10g} d evaluations"


class _Table(Budget):
    """A number of evaluations by dimension, which is a text."""

    plain: dict[str, int]

    def evaluations(self, dimension: int) -> int:
        if str(dimension) not in self.plain:
            known = ", ".join(self.plain)
            raise BenchError(f"the budget has no evaluations for problems of dimension {dimension}; it has {known}")
        return self.plain[str(dimension)]

    @property
    def words(self) -> str:
        return joined([f"{number:,} evaluations at d = {dimension}" for dimension, number in self.plain.items()])

    def within(self, dimensions: Iterable[int | None]) -> Budget:
        kept = set(map(str, dimensions))
        return _Table({d: number for d, number in self.plain.items() if d in kept} or self.plain)

    def spent(self, most: Mapping[int | None, int]) -> Budget:
        return _Table(self.plain | {str(d): number for d, number in most.items() if str(d) in self.plain})
