"""Draw the scores of sets of optimizers."""

from __future__ import annotations

import pandas as pd

from bench.analysis.portfolio import Portfolio
from bench.plots import style
from bench.plots.rows import shares
from bench.report.parts import Figure
from bench.topics.figures import MOST_ROWS, figure_width, left_margin


def portfolio_figure(portfolio: Portfolio) -> Figure:
    """Return the score of each optimizer alone and of the best larger sets, beside that of the virtual best."""
    alone = portfolio.members.sort_values("score", ascending=False, kind="stable")[["optimizer", "score"]]
    sets = portfolio.sets[portfolio.sets["size"] > 1]
    drawn = alone[:MOST_ROWS]
    names = [*style.names(drawn["optimizer"]).values(), *(f"best set of {size}" for size in sets["size"])]
    best, left = float(portfolio.gap["virtual_score"].iloc[0]), left_margin(names)
    figure, (ax,) = style.grid(
        1, width=figure_width(left), height=style.rows_height(len(names)), left=left, right=0.5, bottom=0.45, top=0.08
    )
    shares(names, [*drawn["score"], *sets["score"]], [0] * len(drawn) + [1] * len(sets), best, ax=ax)
    which = (
        "each optimizer" if len(drawn) == len(alone) else f"each of the {len(drawn)} best of {len(alone)} optimizers"
    )
    larger = (
        ", and that of the best set found of each size up to the first within 5% of the virtual best"
        if len(sets)
        else ""
    )
    caption = f"The share of the targets that {which} reaches alone{larger}. Line: the virtual best, {best:.1%}."
    rows = [(optimizer, 1, score) for optimizer, score in alone.itertuples(index=False)]
    rows += [(" + ".join(members), size, score) for size, members, score, _ in sets.itertuples(index=False)]
    return Figure("portfolio-sets", caption, figure, pd.DataFrame(rows, columns=["optimizers", "size", "score"]))
