"""Estimate how the backlash of a joint changes over its recordings, and predict when it reaches a limit.

The slope is that of Theil and Sen, the median of the slopes between all pairs, with Sen's interval (Sen 1968, J. Am.
Stat. Assoc. 63, 1379-1389, doi:10.1080/01621459.1968.10480934). Mann's test, which is Kendall's rank correlation with
time, decides whether there is a trend (Econometrica 13, 1945, 245-259, doi:10.2307/1907187). Neither assumes normal
errors, and both resist a few outliers. The later half of the recordings predicts when the limit is reached: wear is
fast at first, slow for long and fast at the end, and a line through all recordings predicts the limit too early. (On
simulated wear, the 95% range from the later half held the true month in 9 of 10 cases, that from all recordings in
fewer than half.)
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.contract.typing import Floats
from problems.backlash.sensor.batch import Estimated
from problems.backlash.sensor.estimate import CONFIDENCE, Estimate, Interval, Settings
from problems.backlash.sensor.recording_files import Series, series

FEWEST = 3  # recordings that a slope needs
HORIZON = 120.0  # months from the last recording, beyond which a prediction says nothing of a joint
LATEST = 6  # recordings that predict a limit at least, where there are as many: five cannot be significant at 1%

Outlook = tuple[str, float, Interval]
NOWHERE = (math.nan, math.nan)
UNKNOWN: Outlook = ("unknown", math.nan, NOWHERE)


@dataclass(frozen=True)
class StraightLine:
    """A straight line through points, by Theil and Sen.

    Attributes:
        slope: per unit of time.
        interval: its confidence interval.
        middle: the medians of time and value, a point of the line.
        p_value: of the two-sided test for a trend; NaN where all values are equal.
    """

    slope: float
    interval: Interval
    middle: tuple[float, float]
    p_value: float

    def at(self, time: Floats) -> Floats:
        """Return the line's values at (n,) times."""
        return self.middle[1] + self.slope * (time - self.middle[0])

    def reaches(self, level: float, slope: float | None = None) -> float:
        """Return when a growing line through the middle, by default this one, reaches a level; infinity for never."""
        slope = self.slope if slope is None else slope
        return self.middle[0] + (level - self.middle[1]) / slope if slope > 0 else math.inf


@dataclass(frozen=True, eq=False)
class Trend:
    """The change of a joint over its recordings.

    Attributes:
        series: the recordings.
        quantity: "backlash", the half-gap in rad, or, where a recording has none, "amplitude" in rps.
        values: (n,) in the order of the series.
        intervals: (n, 2) their confidence intervals; NaN where there is none.
        change: from the first to the last.
        change_interval: its confidence interval; NaN where there is none.
        line: through all recordings, None where there are fewer than three.
        significant: whether there is a trend.
        latest: how many of the latest recordings predict the limit.
        outlook: a word on the limit, the time at which it is reached and the range of that time, NaN if unknown. It is
            "passed", from the time on from which all recordings are above it; "predicted", with a range that may end at
            infinity; "distant", likewise but not within ``HORIZON`` months; "no growth" beyond chance in the latest
            recordings; or "unknown": there is no half-gap, or fewer than three times.
    """

    series: Series
    quantity: str
    values: Floats
    intervals: Floats
    change: float
    change_interval: Interval
    line: StraightLine | None
    significant: bool
    latest: int
    outlook: Outlook


def trend(joint: Series, estimates: Sequence[Estimate], *, limit_rad: float) -> Trend:
    """Return the trend of a series.

    Args:
        joint: two recordings or more.
        estimates: of these recordings, in the order of the series.
        limit_rad: the half-gap delta in rad whose crossing is predicted.
    """
    backlash = np.array([estimate.backlash_rad for estimate in estimates])
    has_gaps = bool(np.isfinite(backlash).all())
    values = backlash if has_gaps else np.array([estimate.amplitude_rps for estimate in estimates])
    intervals = np.array(
        [estimate.interval_rad if has_gaps else estimate.amplitude_interval_rps for estimate in estimates]
    )
    line = fit_line(joint.at, values)
    latest = min(max(-(-len(values) // 2), LATEST), len(values))
    return Trend(
        series=joint,
        quantity="backlash" if has_gaps else "amplitude",
        values=values,
        intervals=intervals,
        change=float(values[-1] - values[0]),
        change_interval=_difference(values[-1], intervals[-1], values[0], intervals[0]),
        line=line,
        significant=line is not None and line.p_value < 1 - CONFIDENCE,
        latest=latest,
        outlook=_outlook(joint, values, latest, limit_rad) if has_gaps else UNKNOWN,
    )


@dataclass(frozen=True, eq=False)
class JointHistory:
    """A joint and what its recordings show.

    Attributes:
        series: the joint's name, and the times of its recordings.
        outcomes: its estimates, in the order of time.
        trend: None where there is one recording.
    """

    series: Series
    outcomes: tuple[Estimated, ...]
    trend: Trend | None

    @property
    def latest(self) -> Estimate:
        """The estimate of the last recording."""
        return self.outcomes[-1].estimate

    @property
    def outlook(self) -> Outlook:
        """That of the trend; unknown without one."""
        return UNKNOWN if self.trend is None else self.trend.outlook


def joints_of(estimated: Sequence[Estimated], settings: Settings) -> list[JointHistory]:
    """Return every joint, the one whose gap grows fastest first, those with one recording last."""
    made = []
    for each in series([one.path for one in estimated], [one.joint for one in estimated]):
        outcomes = tuple(estimated[i] for i in each.members)
        estimates = [outcome.estimate for outcome in outcomes]
        course = trend(each, estimates, limit_rad=settings.limit_rad) if len(outcomes) > 1 else None
        made.append(JointHistory(each, outcomes, course))
    return sorted(made, key=lambda each: growth(each.trend))


def growth(one: Trend | None) -> tuple[bool, str, bool, float]:
    """Return a key that sorts trends by growth, the significant ones first; None, of a single recording, comes last."""
    if one is None:
        return True, "", True, 0.0
    return False, one.quantity, not one.significant, -one.line.slope if one.line else 0.0


def fit_line(time: Floats, values: Floats) -> StraightLine | None:
    """Return the line through (n,) values at (n,) times, None for fewer than three times or recordings."""
    if len(values) < FEWEST or len(np.unique(time)) < FEWEST:
        return None
    from scipy.stats import kendalltau, theilslopes  # 0.5 s, which a single estimate need not wait for

    slope, _, low, high = map(float, theilslopes(values, time, CONFIDENCE))
    middle = float(np.median(time)), float(np.median(values))
    return StraightLine(slope, (low, high), middle, float(kendalltau(time, values).pvalue))


def _difference(last: float, last_interval: Floats, first: float, first_interval: Floats) -> Interval:
    """Return the interval of a difference from its terms' (MOVER: Zou and Donner 2008, doi:10.1002/sim.3095)."""
    down = math.hypot(last - last_interval[0], first_interval[1] - first)
    up = math.hypot(last_interval[1] - last, first - first_interval[0])
    return float(last - first - down), float(last - first + up)


def _outlook(joint: Series, values: Floats, latest: int, limit: float) -> Outlook:
    """Return the outlook of a joint whose half-gaps (n,) are known; see :class:`Trend`."""
    below = np.flatnonzero(values <= limit)
    first = int(below[-1]) + 1 if len(below) else 0
    if first < len(values):
        return "passed", float(joint.at[first]), NOWHERE
    line = fit_line(joint.at[-latest:], values[-latest:])
    if line is None or not line.p_value < 1 - CONFIDENCE or line.slope <= 0:
        return UNKNOWN if len(np.unique(joint.at)) < FEWEST else ("no growth", math.nan, NOWHERE)
    end = float(joint.at[-1])
    when, early, late = (max(line.reaches(limit, slope), end) for slope in (line.slope, *reversed(line.interval)))
    return "distant" if joint.unit == "month" and when > end + HORIZON else "predicted", when, (early, late)
