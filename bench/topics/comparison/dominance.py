"""The optimizers ranked by U-scores, the ranking of the CEC 2022 competition, on the functions of suites."""

from __future__ import annotations

import pandas as pd

from bench.analysis.instances import SOLVED
from bench.report.parts import Section, Table
from bench.report.wording import count
from bench.topics.findings import Findings, Trials
from bench.topics.topic import Topic

TITLE = "Speed and accuracy in one ranking"


def section(findings: Findings) -> Section | None:
    """Return the ranking of two or more optimizers on functions of suites; None without such a function."""
    functions = findings.trials.suite_functions
    if len(findings.trials.optimizers) < 2 or not functions:
        return None
    scores = findings.anytime.u_scores
    problems = scores["problem"].nunique()
    meaning = (
        "A U-score counts pairs of trials of two optimizers on the same problem (Price, Kumar and Suganthan 2023): of "
        f"two trials that came within {SOLVED:g} of the optimum, the one with fewer evaluations wins; such a "
        "trial wins over any other; of two others, the one with the lower final value wins; ties count half. U-scores "
        "determined the winners of the CEC 2022 competition. The share is that of all pairs of an optimizer; 50% "
        "means that its trials win as often as they lose."
    )
    text = [meaning]
    if left := len(functions) - problems:
        text.append(
            f"{count(left, 'problem')} of {len(functions):,} {'is' if left == 1 else 'are'} left out: the optimum is "
            "unknown or beaten, or the optimizers have different numbers of trials."
        )
    return Section(TITLE, tuple(text), (_scores(findings.trials, scores),) if problems else ())


def _scores(trials: Trials, scores: pd.DataFrame) -> Table:
    dimension = scores["problem"].astype(object).map(trials.dimensions)
    total = scores.groupby("optimizer")[["u", "pairs", "reached", "trials"]].sum().reindex(trials.optimizers)
    shown = pd.DataFrame({"rank": total["u"].rank(ascending=False, method="min").astype(int), "U-score": total["u"]})
    if dimension.nunique() > 1:
        for in_dimension, scores_there in scores.groupby(dimension):
            shown[f"d = {in_dimension:g}"] = scores_there.groupby("optimizer")["u"].sum()
    shown["share %"] = 100 * total["u"] / total["pairs"]
    shown["reached"] = [f"{reached:,}/{of:,}" for reached, of in zip(total["reached"], total["trials"], strict=True)]
    columns = [str(name) for name in shown if name not in ("rank", "share %", "reached")]
    shown = shown.sort_values("rank", kind="stable").rename_axis("optimizer")
    return Table(
        "u-scores",
        f"U-scores over {count(scores['problem'].nunique(), 'problem')}, highest first.",
        shown,
        bold=shown[columns].eq(shown[columns].max()),
        decimals={"share %": 1} | dict.fromkeys(columns, 1),
        note=f"Bold: the highest of a column; reached: trials that came within {SOLVED:g} of the optimum. The "
        "CSV file has the scores by problem.",
        data=scores,
    )


TOPIC = Topic(TITLE, section, place=50)
