"""Who is first on a panel, and whom no test separates from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from bench.analysis.matrix import table
from bench.topics.findings import Final

FIRST, NEAR = "1", "≈"


def ranks_on(final: Final, panels: Mapping[str, Sequence[str]]) -> pd.DataFrame:
    """Return the mean rank of each optimizer on the problems of each panel, panels by optimizers."""
    ranks = table(final.chances, "rank")
    return pd.DataFrame({title: ranks.reindex(list(problems)).mean() for title, problems in panels.items()}).T


def marks(final: Final, panels: Mapping[str, Sequence[str]]) -> pd.DataFrame:
    """Return marks, panels by optimizers: of the first, of those that no test separates from it, and "" of the others.

    On a panel of several problems a test separates them where it shows the first to end lower on any of these.
    """
    ranks = ranks_on(final, panels)
    tests = final.pairs
    tests = tests[tests["p_holm"].notna()]
    shown = tests[tests["lower"] != ""].astype(dict.fromkeys(("problem", "first", "second", "lower"), object))
    higher = shown["second"].where(shown["lower"] == shown["first"], shown["first"])
    by_problem = pd.DataFrame({"problem": shown["problem"], "lower": shown["lower"], "higher": higher})
    tested = {*tests["first"], *tests["second"]}
    found = pd.DataFrame("", index=ranks.index, columns=ranks.columns)
    for title, problems in panels.items():
        own = ranks.loc[title].dropna()
        if len(own) < 2 or own.min() == own.max():
            continue
        first = str(own.idxmin())
        of_panel = by_problem[by_problem["problem"].isin(problems) & (by_problem["lower"] == first)]
        beaten = set(of_panel["higher"])
        subject = final.subject and first != final.subject
        for label in own.index:
            open_pair = label not in beaten and label in tested and (not subject or label == final.subject)
            found.loc[title, label] = FIRST if label == first else NEAR if open_pair else ""
    return found
