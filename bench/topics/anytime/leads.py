"""Find the leaders at each budget: curves of targets reached with bands, and the budgets at which these part."""

from __future__ import annotations

import numpy as np
import pandas as pd

from bench.analysis.bands import curve_bands, leads
from bench.analysis.bands import spells as spells_of
from bench.plots import ecdf, spells, style
from bench.plots.curves import AXES, MOST_BANDS
from bench.report.parts import Figure
from bench.report.prose import speaker
from bench.report.wording import listing
from bench.topics.figures import left_margin, legend_height
from bench.topics.findings import Findings

RIVALS = 8  # of the leader, the nearest ones
POINTS = 60  # of the grid
SAY = speaker(__package__)


def shown_leads(findings: Findings) -> pd.DataFrame:
    """Return when the leader, or a rival of it, is shown to be ahead (:func:`bench.analysis.spells`)."""
    leader, *rivals = findings.from_leader[: RIVALS + 1]
    pairs = [(leader, rival) for rival in rivals]
    return spells_of(leads(*findings.of(compared), pairs=pairs))


def sentences(findings: Findings) -> list[str]:
    """Return sentences on the optimizers ahead at each budget, and on curves that cross; none without a comparison."""
    if not comparable(findings):
        return []
    leader, *rivals = findings.from_leader[: RIVALS + 1]
    shown = findings.of(shown_leads)
    unit = "evaluations / d" if findings.trials.scaled else "evaluations"
    behind = shown["second"].where(shown["ahead"] == leader, leader)
    parts = [
        f"{ahead} of {other} from {_spent(begin)} to {_spent(end)}"
        for ahead, other, begin, end in zip(shown["ahead"], behind, shown["begin"], shown["end"], strict=True)
    ]
    crossed = [rival for rival in rivals if shown.loc[shown["second"] == rival, "ahead"].nunique() > 1]
    return [SAY("leads", leader, parts, unit, crossed, listing(rivals))]


def _spent(evaluations: float) -> str:
    """Return a number of evaluations in two digits, as the grid is no finer."""
    rounded = float(f"{evaluations:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:g}"


def comparable(findings: Findings) -> bool:
    """Whether there are several optimizers, with two trials or more wherever they are compared."""
    return (
        len(findings.trials.optimizers) > 1 and len(findings.final.medians) > 0 and not findings.of(compared)[0].empty
    )


def figure(findings: Findings) -> list[Figure]:
    """Return the curves with their bands above the spells of each rival; none where there is nothing to compare."""
    if not comparable(findings):
        return []
    hits, grid, dimensions = findings.of(compared)
    leader, *rivals = findings.from_leader[: RIVALS + 1]
    drawn = [leader, *rivals][:MOST_BANDS]
    pens = {label: pen for label, pen in findings.display.pens.items() if label in drawn}
    bands = curve_bands(hits[hits["optimizer"].isin(drawn)], grid, dimensions)
    shown = findings.of(shown_leads)
    rows = 0.3 + 0.16 * len(rivals)
    plot, (top, bottom) = style.grid(
        2, columns=1, width=style.COLUMN, height=1.6, left=max(0.5, left_margin(style.names(rivals).values())),
        down=0.35, top=legend_height(pens, style.COLUMN) + 0.1, bottom=0.1,
    )  # fmt: skip
    ecdf(bands, pens=pens, legend=False, ax=top)
    spells(shown, rivals, pens=findings.display.pens, ax=bottom)
    bottom.set_xscale("log")
    bottom.set_xlim(top.get_xlim())
    bottom.set_box_aspect(rows / 3)
    bottom.tick_params(labelbottom=False)
    bottom.set_ylabel("")
    bottom.set_title(f"ahead: {style.plain(leader, 20)}, or the rival", loc="left", fontsize="small")
    style.legend_above(plot, style.handles(pens))
    caption = SAY("caption", leader, len(drawn) < len(findings.trials.optimizers), AXES[bands.columns[1]])
    return [Figure("leads", caption, plot, bands, shown)]


def compared(findings: Findings) -> tuple[pd.DataFrame, np.ndarray, dict[str, int] | None]:
    """Return the hits on problems on which every optimizer has two trials or more, the budgets and the dimensions."""
    hits, trials = findings.anytime.compared_hits, findings.trials
    counts = trials.frame.groupby(["problem", "optimizer"], observed=True).size().unstack()
    kept = [str(label) for label in counts.index[(counts.reindex(columns=trials.optimizers) > 1).all(axis=1)]]
    dimensions = trials.dimensions if trials.scaled else None
    if dimensions is not None:
        kept = [label for label in kept if label in dimensions]
    hits = hits[hits["problem"].isin(kept)]
    if not kept:
        return hits, np.ones(1), dimensions
    most = [(trials.common or trials.budgets)[label] / (dimensions[label] if dimensions else 1) for label in kept]
    first = 1 / max(dimensions[label] for label in kept) if dimensions else 1
    return hits, np.unique(np.geomspace(first, min(most), POINTS)), dimensions
