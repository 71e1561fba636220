"""Figure 1: the chance that a run of one optimizer ends lower, against each rival."""

from __future__ import annotations

from bench.plots import a12_forest, style
from bench.report.parts import Figure
from bench.topics.answer.facts import SHOWN, Facts


def chance_figure(known: Facts) -> Figure:
    """Return the chance that a run ends lower, against each rival, with the intervals of the tests that fill points."""
    rows = known.rivals.head(SHOWN)
    names = style.names(rows["rival"], 18)
    left = style.text_width(names.values(), style.SMALL) + 0.25
    figure, (ax,) = style.grid(
        1, width=style.COLUMN, height=style.rows_height(len(rows)), left=left, bottom=0.36, top=0.08
    )
    a12_forest(rows, names=list(names.values()), ax=ax)
    ax.set_xlabel(f"chance that a run of {style.plain(known.chosen, 24)} ends lower", loc="right")
    more = f" The first {len(rows)} of {len(known.rivals)} rivals." if len(rows) < len(known.rivals) else ""
    tested = (
        f"bars: the intervals of the tests, each at {known.rivals['level'].iloc[0]:.2g}. Filled: the test shows it."
        if known.tested
        else "nothing is tested."
    )
    caption = (
        f"{known.chosen} against each rival, averaged over these problems; right of the line it ends lower; "
        f"{tested}{more}"
    )
    return Figure("leader-against-each", caption, figure, known.rivals)
