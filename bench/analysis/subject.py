"""One optimizer against each of its rivals: the *subject* of a study, which its author asks about.

Only the k - 1 pairs with the subject are hypotheses, not all k (k - 1) / 2: on problems, over all problems
(:func:`bench.analysis.pairwise_tests`, :func:`bench.analysis.across_problems`), and in parts of them and at smaller
budgets, which is where the subject is better or worse than it is in the mean.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import pandas as pd

from bench.analysis.across import across_problems
from bench.analysis.pairwise import holm, of_subject

OUTCOMES = ("better", "worse", "open")
"""What a test says of the subject: it ends lower than the rival, higher, or neither is shown."""

COLUMNS = ("kind", "part", "rival", "problems", "probability", "low", "high", "p", "p_holm", "outcome")


def seen_from(tests: pd.DataFrame, optimizer: str) -> pd.DataFrame:
    """Return the pairs of an optimizer with it as the first one; probabilities and intervals are turned round."""
    turned = tests[tests["second"] == optimizer].rename(columns={"first": "second", "second": "first"})
    ends = {"low": "high", "joint_low": "joint_high"}
    both = ends | {high: low for low, high in ends.items()} | {"probability": "probability"}
    turned = turned.assign(**{name: 1 - turned[other] for name, other in both.items() if other in turned})
    return pd.concat([tests[tests["first"] == optimizer], turned])


def outcome(probability: float, significant: bool) -> str:
    """Return one of :data:`OUTCOMES`, by the probability of the subject to end lower and its test."""
    return OUTCOMES[2] if not significant or probability == 0.5 else OUTCOMES[int(probability < 0.5)]


def signs_of(summary: pd.DataFrame, pairs: pd.DataFrame, subject: str) -> pd.DataFrame:
    """Return problem, optimizer and sign of every cell: the sign of the subject's test against it.

    "+" where the subject is separably lower, "−" where the other one is, "=" where neither is, "" of the subject and
    where nothing is tested. ``summary`` and ``pairs`` are those of :func:`bench.analysis.comparison_matrix`.
    """
    rivals = seen_from(pairs.astype({"first": object, "second": object, "lower": object}), subject)
    own = rivals[rivals["testable"].astype(bool) & rivals["a12"].notna()]
    sign = np.where(own["lower"] == subject, "+", np.where(own["lower"] == "", "=", "−"))
    signs = dict(zip(zip(own["problem"], own["second"], strict=True), sign, strict=True))
    cells = summary[["problem", "optimizer"]]
    return cells.assign(sign=[signs.get(cell, "") for cell in cells.itertuples(index=False, name=None)])


def in_parts(
    pairs: pd.DataFrame,
    parts: Mapping[tuple[str, str], Collection[str]],
    earlier: pd.DataFrame,
    subject: str,
    level: float,
    subjects: int = 1,
) -> pd.DataFrame:
    """Return the subject against each rival in parts of the problems and at smaller budgets, a row each.

    Columns: kind and part, as of ``parts``, or "budget" and the share; rival, problems; the ``probability`` that a run
    of the subject ends lower, in the mean over the problems, with its 95% interval (not at smaller budgets); ``p``, and
    p_holm, adjusted over all rows; ``outcome``, one of :data:`OUTCOMES` at the ``level``.

    Args:
        pairs: of :func:`bench.analysis.pairwise_tests`.
        parts: the problems of each part, by its kind, such as "dimension", and its name.
        earlier: of :func:`bench.analysis.earlier_leads`, with the subject as the leader.
        subject: the label of the subject.
        level: of all rows together.
        subjects: how many could have been chosen, where the subject was named after the results: with each of them
            as many tests could have been read, every pair of them twice.
    """
    own = pairs[of_subject(pairs, subject)]
    rows = [
        seen_from(across_problems(own[own["problem"].isin(list(problems))]), subject).assign(kind=kind, part=part)
        for (kind, part), problems in parts.items()
    ]
    before = earlier.assign(
        kind="budget", part=earlier["share"].map(lambda share: f"{share:.0%}"), second=earlier["optimizer"],
        probability=1 - earlier["probability"].astype(float), problems=0, low=np.nan, high=np.nan,
    )  # fmt: skip
    table = pd.concat([each for each in (*rows, before) if len(each)] or [before], ignore_index=True)
    table = table.rename(columns={"second": "rival"})
    p_holm = np.minimum(holm(table["p"].to_numpy(dtype=float)) * max(subjects / 2, 1), 1.0)
    shown = zip(table["probability"].astype(float), p_holm <= level, strict=True)
    return table.assign(p_holm=p_holm, outcome=[outcome(*each) for each in shown])[list(COLUMNS)]
