"""How figures look: one style, and colours that never carry meaning alone."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal

import matplotlib
import matplotlib.figure
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import ArrayLike

# Okabe and Ito (2008), safe for colour-blind readers; yellow last, as it is faint on white.
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#000000", "#F0E442")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINES = ("-", "--", "-.", ":", (0, (5, 1)))
HATCHES = ("", "///")
REFERENCE = "#D55E00"  # expected values and limits

MANY_POINTS = 20_000  # beyond so many markers a figure keeps them as an image, or the page would not load

RC: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "savefig.dpi": 150,
    "svg.hashsalt": "backlash-bench",  # identical figures must be identical files
    "svg.fonttype": "none",  # text stays text: small, searchable, read aloud
    "pdf.fonttype": 42,  # TrueType, which journals ask for
}

# The user's own settings must not change a report; the backend is theirs, since no window is ever opened.
DEFAULTS: dict[str, Any] = {key: value for key, value in matplotlib.rcParamsDefault.items() if "backend" not in key}


@dataclass(frozen=True)
class Look:
    """The colour, marker and line by which one optimizer is told in every figure."""

    color: str
    marker: str
    line: Any


def context() -> AbstractContextManager[None]:
    """Return the context in which every figure of a report is drawn and saved, the user's own settings aside."""
    settings: Any = {**DEFAULTS, **RC}  # matplotlib's own type lists every key
    return matplotlib.rc_context(settings)


def looks(labels: list[str]) -> dict[str, Look]:
    """Return a look for each label; the cycles have coprime lengths, so the first 280 all differ."""
    return {
        label: Look(PALETTE[i % len(PALETTE)], MARKERS[i % len(MARKERS)], LINES[i % len(LINES)])
        for i, label in enumerate(labels)
    }


def plain(label: str, at_most: int = 28) -> str:
    """Return a label as a figure may show it: one short line, no control characters, no mathematics."""
    clean = " ".join("".join(c if c.isprintable() else " " for c in label).split())
    short = clean if len(clean) <= at_most else clean[: at_most - 1] + "…"
    return short.replace("$", r"\$")


def panels(
    number: int, *, columns: int = 3, width: float = 10.0, height: float = 2.2, margin: float = 0.6,
    sharex: bool = False, sharey: bool = False,
) -> tuple[matplotlib.figure.Figure, list[Axes]]:  # fmt: skip
    """Return a figure of small multiples and its axes, row by row, each row ``height`` inches high."""
    columns = max(min(columns, number), 1)
    rows = max(ceil(number / columns), 1)
    figure = matplotlib.figure.Figure(figsize=(width, rows * height + margin), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=sharex, sharey=sharey).ravel()
    for unused in axes[number:]:
        unused.remove()
    return figure, list(axes[:number])


def spread(count: int, width: float = 0.5) -> np.ndarray:
    """Return (count,) offsets within +-width/2 that keep neighbouring points apart, the same every time."""
    golden = 0.6180339887498949
    return ((np.arange(count) * golden) % 1 - 0.5) * width


def is_wide(values: ArrayLike, ratio: float = 30.0) -> bool:
    """Return whether values, all positive, span so much that a log axis reads better."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    return bool(len(finite) and finite.min() > 0 and finite.max() > ratio * finite.min())


def log_scale(ax: Axes, which: Literal["x", "y"]) -> None:
    """Make an axis that is already drawn on logarithmic, with plain numbers at 1, 2 and 5 where it spans little."""
    getattr(ax, f"set_{which}scale")("log")
    low, high = getattr(ax, f"get_{which}lim")()
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 200 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}" if value >= 1000 else f"{value:g}"))
    axis.set_minor_locator(NullLocator())
