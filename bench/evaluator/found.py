"""What is found of a candidate, and the words for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import pandas as pd

from bench.helpers.text import count, listing
from bench.trial.trial import ROUNDING

LONGEST = 60  # words of a feedback
LEAST = 1e-9
"""The least score of a candidate that did not fail."""


@dataclass(frozen=True)
class Found:
    """What the training problems show of a candidate.

    Attributes:
        score: the mean AOCC over the training problems, in [0, 1], higher is better; 0 if it failed.
        error_bar: its standard error over the seeds; missing (NaN) with one trial a problem.
        error: why it failed, as in "line 12: IndexError: index 7 is out of bounds (y = x[7])"; "" where it did not.
        feedback: at most 60 words for a generator.
        frame: a row for each trial, with its ``aocc``.
        by_problem: a row for each problem, with the mean AOCC of the candidate and of each baseline.
        notes: what must be known of the score, such as that the optimum of a problem is unknown.
    """

    score: float
    error_bar: float
    error: str
    feedback: str
    frame: pd.DataFrame = field(repr=False)
    by_problem: pd.DataFrame = field(repr=False)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Final:
    """What the held-out problems show of one candidate; printed, it is the sentences.

    Attributes:
        table: a row for each baseline: ``rival``, ``problems``, ``chance`` that a run of the candidate ends lower, its
            interval ``low`` to ``high``, ``p``, ``level`` of the test and ``outcome``.
        frame: a row for each trial.
        judged: sources that were judged before, on the training problems.
        finals: how often the held-out problems were used before.
        error: why the candidate failed, "" where it did not.
    """

    table: pd.DataFrame
    frame: pd.DataFrame = field(repr=False)
    judged: int = 0
    finals: int = 0
    error: str = ""

    def __str__(self) -> str:
        if self.error:
            return f"It failed: {self.error}"
        lines = []
        for row in self.table.to_dict("records"):
            where = f"on {count(row['problems'], 'held-out problem')}"
            seen = f"{row['chance']:.1%} ({row['low']:.1%} to {row['high']:.1%}, p = {row['p']:.2g})"
            shown = {"better": "It is better than", "worse": "It is worse than"}.get(
                row["outcome"], "It is open against"
            )
            lines.append(f"{shown} {row['rival']} {where}: the chance that its run ends lower is {seen}.")
        lines.append(f"{count(self.judged, 'candidate')} had been judged on the training problems.")
        if self.finals:
            lines.append(
                f"These held-out problems had been used {count(self.finals, 'time')} before: they are spent, and p "
                "holds for the first use alone. Choose others."
            )
        return "\n".join(lines)


def feedback(score: float, bar: float, by_problem: pd.DataFrame, used: float) -> str:
    """Return the score, where it is strong and weak against the baselines, and the share of evaluations used."""
    rivals = by_problem.drop(columns="candidate")
    lead = by_problem["candidate"] - rivals.max(axis=1)
    best, worst = str(lead.idxmax()), str(lead.idxmin())
    means = ", ".join(f"{label} {mean:.3f}" for label, mean in rivals.mean().items())
    spread = "" if pd.isna(bar) else f" ± {bar:.3f}"
    return shortened(
        f"AOCC {score:.3f}{spread} (higher is better; {means}). Against the best baseline of each problem, strongest "
        f"on {best} ({lead[best]:+.3f}), weakest on {worst} ({lead[worst]:+.3f}), and ahead on {int((lead > 0).sum())} "
        f"of {len(lead)}. Used {used:.0%} of the evaluations."
    )


def shortened(text: str) -> str:
    """Return the first words of a text, as many as a feedback may have."""
    words = text.split()
    return " ".join(words if len(words) <= LONGEST else [*words[: LONGEST - 1], "…"])


def notes(frame: pd.DataFrame, optima: Mapping[str, float], assumed: Sequence[str]) -> tuple[str, ...]:
    """Return sentences on problems whose optimum is unknown, or beaten by a trial of the candidate."""
    lowest = {str(label): float(low) for label, low in frame.groupby("problem", sort=False)["fun"].min().items()}
    beaten = [label for label, low in lowest.items() if low < optima[label] - ROUNDING * max(1.0, abs(optima[label]))]
    unknown = [label for label in assumed if label in lowest]
    found = []
    if unknown:
        found.append(
            f"The optimum of {listing(unknown, 3)} is unknown: the lowest value of the baselines stands for it."
        )
    if beaten:
        found.append(f"The candidate ends below the optimum that is used of {listing(beaten, 3)}.")
    return tuple(found)
