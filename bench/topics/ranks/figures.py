"""Mean ranks, and the chance of each pair, over all problems."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import pandas as pd

from bench.plots import a12_forest, cd_diagram, style
from bench.plots.ranks import RANK_NAME, cd_height, forest_names
from bench.report.parts import Figure
from bench.topics.figures import figure_width, left_margin


def rank_figure(
    mean_ranks: pd.Series[float], cliques: Collection[Sequence[str]], nemenyi: float | None = None
) -> Figure:
    """Return the critical-difference diagram of mean ranks over problems; a bar joins those of a clique.

    ``nemenyi`` is the critical difference, where the cliques are those of that test.
    """
    side = style.text_width(style.names(mean_ranks.index, RANK_NAME).values()) + 0.5
    figure, (ax,) = style.grid(
        1, width=figure_width(2 * side),
        height=cd_height(mean_ranks.count(), len(cliques)), left=side, right=side, bottom=0.05,
        top=0.3 if nemenyi is None else 0.55,
    )  # fmt: skip
    cd_diagram(mean_ranks, cliques, nemenyi, ax=ax)
    joins = "no pair of which differs significantly on these problems (Holm)"
    if nemenyi is not None:
        joins = f"whose ranks are less than the critical difference of Nemenyi’s test apart, {nemenyi:.2f} (level 0.05)"
    caption = (
        "Critical-difference diagram: mean ranks over problems by the rivals beaten, the best at the left. A bar joins "
        f"optimizers {joins}."
    )
    name = "ranks" if nemenyi is None else "ranks-nemenyi"
    return Figure(name, caption, figure, mean_ranks.rename_axis("optimizer").reset_index(name="mean_rank"))


def forest_figure(pairs: pd.DataFrame) -> Figure:
    """Return the probability of each pair to end lower over all problems, with its intervals and its test."""
    left = left_margin(forest_names(pairs))
    height = style.rows_height(len(pairs))
    figure, (ax,) = style.grid(1, width=figure_width(left), height=height, left=left, bottom=0.5, top=0.08)
    a12_forest(pairs, ax=ax)
    caption = (
        "The probability that a run of the first optimizer ends lower than one of the second, averaged over these "
        "problems, with 95% intervals that hold for all pairs together. A point is filled where the test on these "
        "problems is significant (Holm). Dotted: the bounds of small, medium and large effects on both sides of 0.5."
    )
    return Figure("probability-to-end-lower", caption, figure, pairs)
