"""The targets of a study: values that count as reached, from which running times and success rates follow."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bench.contract.numbers import is_finite
from bench.contract.typing import Floats
from bench.helpers.errors import BenchError
from bench.helpers.text import joined
from bench.study.values import Value

if TYPE_CHECKING:
    import pandas as pd

PRECISIONS = (10.0, 1.0, 1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-8)
"""The precisions f - f_opt of COCO's tables of expected running times."""

COCO_PRECISIONS: Floats = np.array(
    [10.0 ** (step / 5) if step % 5 else float(f"1e{step // 5}") for step in range(10, -41, -1)]
)
"""The 51 target precisions of COCO, five a decade from 1e2 to 1e-8 (Hansen et al. 2021)."""

RUN_LENGTHS = (0.5, 1.2, 3.0, 10.0, 50.0)
"""The budgets over d of targets by running length, as in cocopp's tables for expensive functions."""

QUANTILES: Floats = np.arange(19.0, 0.0, -1.0, dtype=np.float64) / 20
"""The quantiles of the best values of all trials on a problem."""

MULTIPLES: Floats = np.array([8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125])
"""The multiples of the tolerance of an expected metric: 1 is the tolerance itself."""

PER_DECADE = 10
DECADES_KNOWN = 8  # to 1e-8, the last target of COCO
DECADES_FOUND = 3  # a harder target only distinguishes the trial that found f_L from the rest
_LADDER = 10.0 ** (-np.arange(PER_DECADE * DECADES_KNOWN + 1) / PER_DECADE)

MOST = 1000  # targets of a list
TABLED = 8  # targets of a list that a table shows at most

_LENGTHS = joined([f"{length:g}" for length in RUN_LENGTHS])
_PERCENT = re.compile(r"\s*([0-9]*\.?[0-9]+(?:[eE][+-]?[0-9]+)?)\s*%\s*", re.ASCII)


def fractions(known: bool) -> Floats:
    """Return the ladder of tau, falling from 1, ten a decade: to 1e-8 where the optimum is known, else to 1e-3."""
    return _LADDER[: PER_DECADE * (DECADES_KNOWN if known else DECADES_FOUND) + 1]


class Found(NamedTuple):
    """The values that the trials on a problem found, from which its targets follow.

    Attributes:
        reference: the optimum where that is ``known``, or the lowest value found where it is unknown or beaten.
        known: whether the reference is the optimum.
        first: the median of the first values of the trials.
        finals: the best value of each trial, +inf of a failed one.
    """

    reference: float
    known: bool
    first: float
    finals: Floats


class Targets(Value, ABC):
    """A set of targets. Each has a level, tau; a lower one is harder.

    Attributes:
        unit: what a level is, such as "precision". That of a running length is d / budget.
        short: the set's name in a table.
        levels: the levels of the success rates, from easy to hard.
        level: that of data profiles, scaling and spreads.
        tabled: those of the tables of running times, from easy to hard.
        absolute: whether targets are precisions, so that an ERT can stand beside a published one.
        restarts: whether shares of targets reached are those of simulated restarts, as the field reports them.
        rising: whether readers are shown 1 / level, which rises.
        by_best: whether the best of 2009 sets the targets.
        by_metric: whether expected metrics set them, and not values of the objective.
        without: the problems that have no target.
    """

    unit: str
    short: str
    levels: tuple[float, ...]
    level: float
    tabled: tuple[float, ...]
    absolute = rising = by_best = by_metric = False
    restarts = True
    without = "on which no trial found a finite value"
    _meaning: str  # of a target; {0} is the set, {1} what values are beside

    @staticmethod
    def read(value: object, what: str = "the targets") -> Targets:
        """Return targets of a plain value, each once, from the easiest to the hardest.

        Args:
            value: one of :data:`KINDS`; positive precisions; percentages of the optimum such as ``"1%"``; or a text of
                either, separated by commas.
            what: the subject of a sentence about it.

        Raises:
            BenchError: for anything else.
        """
        if isinstance(value, Targets):
            return value
        if isinstance(value, str) and value.strip() in KINDS:
            return KINDS[value.strip()]
        parts: Sequence[object] = value if isinstance(value, list | tuple) else ()
        if isinstance(value, str):
            parts = [_number(part) for part in value.split(",")]
        numbers = [float(part) for part in parts if is_finite(part) and part > 0]
        percents = [percent for part in parts if isinstance(part, str) and 0 < (percent := _percent(part)) < np.inf]
        if 0 < len(parts) == len(numbers) <= MOST:
            return _OwnPrecisions(sorted(set(numbers), reverse=True))
        if 0 < len(parts) == len(percents) <= MOST:
            return _Percentages([f"{percent:.12g}%" for percent in sorted(set(percents), reverse=True)])
        *kinds, last = map(repr, KINDS)
        raise BenchError(
            f"{what} must be {', '.join(kinds)} or {last}, up to {MOST:,} positive precisions such as [1e-1, 1e-3], or "
            f"percentages of the optimum such as ['5%', '1%'], not {value!r}"
        )

    @abstractmethod
    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        """Return the levels and the targets of a problem, from easy to hard; a missing target is none."""

    def meaning(self, known: Sequence[bool]) -> str:
        """Return in sentences what a target is; ``known`` says of each problem if its optimum is known."""
        found = "the lowest value that any trial found (every optimum is unknown or beaten)"
        if any(known):
            found = "the known optimum, or the lowest value found where the optimum is unknown or beaten"
        return self._meaning.format(self, "the known optimum" if all(known) else found)

    def level_text(self, level: float) -> str:
        """Return a level as readers are shown it, such as ``"1e-08"``."""
        return f"{1 / level if self.rising else level:g}"

    def in_unit(self, table: pd.DataFrame, column: str = "tau") -> pd.DataFrame:
        """Return a table whose column of levels is as readers are shown it."""
        return table.assign(**{column: 1 / table[column].astype(float)}) if self.rising else table

    def at(self, level: float) -> str:
        """Return a target as text: ``"tau = 0.01"``, ``"precision = 1e-08"``, ``"5% of the optimum"``."""
        return f"{self.unit} = {level:g}"

    def require_metric(self, there: bool) -> None:
        """Raise BenchError where targets need a problem with an expected metric and none is ``there``."""
        if self.by_metric and not there:
            raise BenchError(
                "targets by tolerance need a problem with an expected metric, and this study has none; choose other "
                "targets, such as relative"
            )


class _Relative(Targets):
    """Shares of the distance from each problem's first values to the optimum, from 1 to 1e-8 (Moré and Wild 2009)."""

    unit, short, levels, level, tabled = "tau", "relative", (1e-1, 1e-2, 1e-3), 1e-2, (1e-1, 1e-2, 1e-3)
    restarts = False
    _meaning = (
        "A target is the objective value f_L + tau (f_0 − f_L), where f_0 is the median of the first values of the "
        "trials and f_L is {1} (Moré and Wild 2009)."
    )

    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        distance = found.first - found.reference
        tau = fractions(found.known) if distance > 0 else np.zeros(1)
        return tau, found.reference + tau * max(distance, 0.0)

    def meaning(self, known: Sequence[bool]) -> str:
        deep, short = (f"{fractions(deeper)[-1]:g}" for deeper in (True, False))
        last = deep if all(known) else f"{deep} where f_L is the optimum, else to {short}" if any(known) else short
        return f"{super().meaning(known)} Targets fall from tau = 1 to {last}."


class _Precisions(Targets):
    """COCO's 51 precisions, the best value less the optimum, from 1e2 to 1e-8."""

    unit, short, levels, level, tabled = "precision", "precisions", (1.0, 1e-2, 1e-8), 1e-2, PRECISIONS
    absolute = True
    _meaning = (
        "The targets are 51 precisions from 1e2 to 1e-8, five a decade, as in COCO (Hansen et al. 2021): the best "
        "value less {1}."
    )

    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        return COCO_PRECISIONS, found.reference + COCO_PRECISIONS


class _RunLengths(Targets):
    """The precisions that the best of 2009 reached next after 0.5, 1.2, 3, 10 and 50 d evaluations.

    :func:`bench.analysis.runlength_targets` computes them.
    """

    unit, short, tabled = "budget / d", "running lengths", tuple(1 / length for length in RUN_LENGTHS)
    levels, level = tabled[2:], tabled[3]
    absolute = rising = by_best = True
    without = "whose optimum was beaten, or on which the best of 2009 has no running time"
    _meaning = (
        f"Targets are by running length, as in cocopp: for {_LENGTHS} times d evaluations, the precision next to the "
        "hardest that the best of 2009 reached within them (five a decade, to 1e-8)."
    )

    def rungs(self, found: Found) -> tuple[Floats, Floats]:  # noqa: ARG002 - they follow from no trial
        return np.empty(0), np.empty(0)

    def at(self, level: float) -> str:
        return f"the target for {self.level_text(level)} d evaluations"


class _Quantiles(Targets):
    """Quantiles of the best values of all trials on each problem."""

    unit, short = "quantile", "quantiles"
    levels, level, tabled = (0.5, 0.25, 0.1), 0.25, (0.75, 0.5, 0.25, 0.1, 0.05)
    _meaning = (
        "The targets of a problem are quantiles of the best values of all its trials, from 0.95 to 0.05: that of 0.1 "
        "is the value that a tenth of all trials reached. They depend on the optimizers compared."
    )

    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        finals = found.finals if len(found.finals) else np.array([np.inf])
        values = np.quantile(finals, QUANTILES, method="inverted_cdf")
        return QUANTILES, np.where(np.isfinite(values), values, np.nan)


class _Tolerance(Targets):
    """Multiples of the tolerance of an expected metric.

    :func:`bench.analysis.tolerance_times` has the times to them, as the values of a trace do not show a metric.
    """

    unit, short, levels, level, tabled = "tolerances", "tolerance", (2.0, 1.0, 0.5), 1.0, (4.0, 2.0, 1.0, 0.5, 0.25)
    by_metric = True
    without = "without an expected metric"
    _meaning = (
        "A trial reaches a target when the expected metrics of its best point are within a multiple of their "
        "tolerances, from 8 to 1/8; its time is the evaluation that found this point. Metrics of points on the way are "
        "not recorded."
    )

    def rungs(self, found: Found) -> tuple[Floats, Floats]:  # noqa: ARG002 - the same on all problems
        return MULTIPLES, MULTIPLES

    def at(self, level: float) -> str:
        return f"{level:g} times the tolerance"


class _List(Targets):
    """A list of levels, or of texts of them."""

    plain: list[float] | list[str]

    def __init__(self, plain: list[float] | list[str]) -> None:
        super().__init__(plain)
        levels, tabled = (
            tuple(self.taus[np.unique(np.linspace(0, len(plain) - 1, most).round().astype(int))].tolist())
            for most in (3, TABLED)
        )
        for name, value in {"levels": levels, "level": levels[len(levels) // 2], "tabled": tabled}.items():
            object.__setattr__(self, name, value)  # as the value is frozen

    @property
    def taus(self) -> Floats:
        return np.array([_percent(each) / 100 if isinstance(each, str) else each for each in self.plain])


class _OwnPrecisions(_List):
    """Precisions, the best value less the optimum."""

    unit, short = "precision", "these precisions"
    absolute = True
    _meaning = "The targets are {0.described}: the best value less {1}."

    @property
    def described(self) -> str:
        first, last = self.level_text(self.tabled[0]), self.level_text(self.tabled[-1])
        return f"{len(self.plain)} precisions from {first} to {last}" if first != last else f"the precision {first}"

    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        return self.taus, found.reference + self.taus


class _Percentages(_List):
    """Percentages of the optimum."""

    unit, short = "share of the optimum", "percentages"
    without = "where no trial found a finite value or the optimum is 0"
    _meaning = "The targets are values within {0.all} of {1}; a value of 0 has none."

    @property
    def all(self) -> str:
        return ", ".join(map(str, self.plain))

    def rungs(self, found: Found) -> tuple[Floats, Floats]:
        return self.taus, found.reference + self.taus * (abs(found.reference) or np.nan)

    def at(self, level: float) -> str:
        return f"{100 * level:g}% of the optimum"


KINDS: dict[str, Targets] = {
    "precisions": _Precisions("precisions"), "runlength": _RunLengths("runlength"), "relative": _Relative("relative"),
    "quantiles": _Quantiles("quantiles"), "tolerance": _Tolerance("tolerance"),
}  # fmt: skip
"""The sets of targets that have a name."""


def _percent(text: str) -> float:
    match = _PERCENT.fullmatch(text)
    return float(match[1]) if match else np.nan


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
