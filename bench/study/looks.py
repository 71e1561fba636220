"""The declared looks of a study: the numbers of trials at which a run compares the optimizers and may stop cells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import pairwise

from bench.errors import BenchError, nearest
from bench.families import function_of
from bench.numbers import MOST_TRIALS, is_whole

EXAMPLE = "as in [looks] trials = [10, 20, 30]"
LEAST = 6  # trials: with fewer not even complete separation has a p of at most 0.05


class Looks(tuple[int, ...]):
    """Two or more increasing numbers of trials; none where a study declares no looks."""

    __slots__ = ()

    @classmethod
    def read(cls, value: object, what: str) -> Looks:
        """Return looks from a table with a list ``trials``, as in a study's file, or from the list alone.

        ``what`` is the subject of a sentence about them, such as ``"'looks'"``. An empty tuple is no looks.

        Raises:
            BenchError: for anything else than two or more increasing numbers of trials.
        """
        if value == ():
            return cls()
        if isinstance(value, Mapping):
            for key in value:
                if key != "trials":
                    raise BenchError(
                        f"{what} has an unknown key {key!r}{nearest(str(key), ['trials'])}; it has trials alone"
                    )
            value = value.get("trials")
        if not isinstance(value, list | tuple) or not all(map(is_whole, value)):
            raise BenchError(f"{what} must be a list of numbers of trials, {EXAMPLE}, not {value!r}")
        looks = cls(map(int, value))
        if len(looks) < 2:
            raise BenchError(f"{what} must be two or more, {EXAMPLE}; a single look at the end needs no declaration")
        if max(looks) > MOST_TRIALS:
            raise BenchError(f"{what} must be at most {MOST_TRIALS:,} trials, not {max(looks)}")
        if not all(one < following for one, following in pairwise(looks)):
            raise BenchError(f"{what} must increase, {EXAMPLE}, not {list(looks)}")
        if looks[0] < LEAST:
            raise BenchError(
                f"{what} must begin with {LEAST} trials or more, not {looks[0]}: no test of fewer can be significant"
            )
        return looks

    @property
    def plain(self) -> dict[str, list[int]] | None:
        """The table as a study's file has it; None without looks."""
        return {"trials": list(self)} if self else None

    @property
    def words(self) -> str:
        """The numbers of trials, such as ``"10, 20, 30"``."""
        return ", ".join(map(str, self))

    def require_fit(self, trials: int, optimizers: int, problems: Iterable[str], where: str = "") -> None:
        """Raise BenchError where looks do not suit a study's trials, its number of optimizers or its problems.

        ``where`` begins the sentence.
        """
        if not self:
            return
        if trials != self[-1]:
            raise BenchError(
                f"{where}'trials' is {trials}, but the last of the declared looks is at {self[-1]} trials; leave out "
                "the number, or declare other looks before the first trial is made"
            )
        if optimizers < 2:
            raise BenchError(f"{where}'looks' needs two optimizers or more: with one, no look can decide anything")
        if several := next(
            (function for function, number in Counter(map(function_of, problems)).items() if number > 1), ""
        ):
            raise BenchError(
                f"{where}'looks' compares problem by problem, but reports pool the instances of {several!r}; take one "
                "instance of each function, or leave out the looks"
            )
