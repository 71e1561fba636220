"""The look of all plots: one style, sizes for papers, and colours that never carry meaning alone.

Every function of :mod:`bench.plots` draws with the matplotlib settings of its caller; a report draws inside
``with style.context():``.
"""

from __future__ import annotations

import unicodedata
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from hashlib import blake2b
from itertools import compress, takewhile
from math import ceil
from pathlib import Path
from typing import Any, Literal

import matplotlib
import matplotlib.figure
import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FixedFormatter, FuncFormatter, LogLocator, MaxNLocator, NullLocator
from matplotlib.typing import LineStyleType
from numpy.typing import ArrayLike, NDArray

from bench.helpers.errors import BenchError, nearest
from bench.helpers.frames import labels

RC = matplotlib.rc_params_from_file(Path(__file__).with_name("report.mplstyle"), use_default_template=False)

POINT = 1 / 72.27  # inches: of TeX, in whose points document classes give their widths
TALLEST = 8.0  # inches that the rows of a figure may take together: a page
ROW = 0.2  # inches, a row of a figure with a label on its left
TICK = 0.36  # inches that a number below an axis takes
LEGEND_ROW = 0.145  # inches, a row of a legend
RIGHT = 0.2  # inches, the margin right of the panels
X_LABEL, Y_LABEL = 0.2, 0.15  # inches from an axis to the name below it, and of the name from the figure's left edge
POINTS, SMALL = float(RC["font.size"]), 6.67  # of text, and of numbers on axes ("small" is 0.833 of the size)

# Okabe and Ito (2008), safe for colour-blind readers, with brown for their yellow, faint on white, and two more.
PALETTE = (
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#000000", "#8C6D31", "#882255", "#6A51C7",
)  # fmt: skip
GREY = "#BDBDBD"  # of optimizers in the background
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINES: tuple[LineStyleType, ...] = ("-", "--", "-.", ":", (0, (5, 1)))
HATCHES = ("", "///")
REFERENCE = "#D55E00"  # expected values and limits
DARK = "#111111"  # of text on colours, which a dark page leaves as it is, unlike black

MANY_POINTS = 20_000  # a plot with more markers keeps them as an image, or the page would not load
HUGE = 1e100  # above it matplotlib's margins may overflow
WIDE = 30.0  # the ratio of the largest to the least value above which a log axis reads better
MANY_NAMES = 30  # nobody can read a longer legend
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# A user's own settings must not change a report, except the backend: a report opens no window.
DEFAULTS: dict[str, object] = {key: value for key, value in matplotlib.rcParamsDefault.items() if "backend" not in key}


@dataclass(frozen=True)
class Pen:
    """The colour, marker and line style that identify one optimizer in every figure."""

    color: str
    marker: str
    line: LineStyleType
    background: bool = False
    width: float = 1.0  # of lines, times that of the plot


Pens = Mapping[str, Pen]


COLUMN, PAGE = 252 * POINT, 516 * POINT
"""The widths of figures in inches: of a column, and of the whole text of two columns, as in IEEE's journals."""


@contextmanager
def context() -> Iterator[None]:
    """Draw and save figures as a report does, whatever the user's own settings."""
    settings: Any = {**DEFAULTS, **RC}  # matplotlib's own type lists every key
    with matplotlib.rc_context(settings):
        yield


def pens(labels: Iterable[str], best: Collection[str] | None = None) -> Pens:
    """Return a pen for each label, which depends on the labels but not on their order; the first 280 all differ.

    An optimizer keeps its colour from report to report as far as colours suffice: hashes of a label and a colour
    (BLAKE2b) are the order in which labels take colours, each the first one that nobody has. So another label seldom
    changes a pen. Labels beyond the ten colours take them again, with other markers and lines.

    With ``best``, only these have a pen of their own; the others are drawn in grey, behind them.
    """
    every = list(labels)
    left = every if best is None else [label for label in every if label in best]
    pen_of: dict[str, Pen] = {}
    turn = 0
    while left:
        colours = _colours(left)
        for label, colour in colours.items():
            place = colour + turn
            pen_of[label] = Pen(PALETTE[colour], MARKERS[place % len(MARKERS)], LINES[place % len(LINES)])
        left = [label for label in left if label not in colours]
        turn += 1
    return {label: pen_of.get(label, Pen(GREY, "", "-", background=True)) for label in every}


def _colours(labels: Sequence[str]) -> dict[str, int]:
    """Return the colour, by number, of as many of the labels as there are colours."""
    wishes = sorted(
        (blake2b(f"{colour} {label}".encode(), digest_size=8).digest(), label, colour)
        for label in labels
        for colour in range(len(PALETTE))
    )
    colour_of: dict[str, int] = {}
    for _, label, colour in wishes:
        if label not in colour_of and colour not in colour_of.values():
            colour_of[label] = colour
    return colour_of


def behind_first(pens: Pens) -> list[tuple[str, Pen]]:
    """Return labels and pens in the order of drawing: those in the background first, and thick ones last."""
    return sorted(pens.items(), key=lambda item: (not item[1].background, item[1].width))


def standing_out(pens: Pens, subject: str) -> Pens:
    """Return the pens with thicker lines of a subject, and paler colours of its rivals; the pens without a subject."""
    if subject not in pens:
        return pens
    quiet = np.array(to_rgb(GREY))
    paler = {
        label: replace(pen, color=to_hex(tuple(0.4 * np.array(to_rgb(pen.color)) + 0.6 * quiet)))
        for label, pen in pens.items()
    }
    return paler | {subject: replace(pens[subject], line="-", width=1.8, background=False)}


def mark(figure: matplotlib.figure.Figure, subject: str) -> None:
    """Write the name of a subject in bold letters wherever it stands in a figure: at an axis, line or legend."""
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if isinstance(axis.get_major_formatter(), FixedFormatter):
                axis.get_ticklabels()  # which names them; the names of others are numbers
    for text in figure.findobj(Text):
        if isinstance(text, Text) and text.get_text() == plain(subject, max(len(text.get_text()), 1)):
            text.set_fontweight("bold")


def pens_of(frame: pd.DataFrame, chosen: Pens | None = None) -> Pens:
    """Return the pens given, or one for each optimizer of a frame, in the study's order where the frame knows it."""
    return pens(labels(frame, "optimizer")) if chosen is None else chosen


def plain(label: str, at_most: int = 28) -> str:
    """Return a label for a figure: one short line without control characters or mathematics.

    A long label keeps its beginning and its end, where similar labels mostly differ.
    """
    clean = " ".join("".join(c if c.isprintable() else " " for c in label).split())
    end = at_most // 3
    short = clean if len(clean) <= at_most else f"{clean[: at_most - 1 - end]}…{clean[-end:]}"
    return short.replace("$", r"\$")


def names(labels: Iterable[str], at_most: int = 24) -> dict[str, str]:
    """Return a short name for each label, all of them distinct: of a sweep with long labels, the values that differ.

    Long labels that would still read the same begin where they differ, or else have a number.
    """
    texts = _differing(list(labels), at_most)
    short = {label: plain(text, at_most) for label, text in texts.items()}
    for group in _alike(short):
        alike_letters = takewhile(lambda letters: len(set(letters)) == 1, zip(*group, strict=False))
        start = max(len(list(alike_letters)) - 3, 0)
        short |= {label: plain("…" + label[start:], at_most) for label in group}
    left = [label for group in _alike(short) for label in group]
    return short | {label: f"{plain(label, at_most - 4)} {number}" for number, label in enumerate(left, 1)}


def _alike(short: Mapping[str, str]) -> list[list[str]]:
    """Return the labels that have one name, for each name of several."""
    alike: dict[str, list[str]] = {}
    for label, name in short.items():
        alike.setdefault(name, []).append(label)
    return [group for group in alike.values() if len(group) > 1]


def _differing(labels: Sequence[str], at_most: int) -> dict[str, str]:
    """Return each label; of those as ``name[a=1,b=2]`` that share a name and are too long, without what all share.

    Where this is still too long, the values stand without the names of their parameters, after as much of ``name`` as
    fits.
    """
    texts = {label: label for label in labels}
    sweeps: dict[tuple[str, int], dict[str, list[str]]] = {}
    for label in labels:
        name, bracket, values = label.partition("[")
        if bracket and values.endswith("]"):
            parts = values[:-1].split(",")
            sweeps.setdefault((name, len(parts)), {})[label] = parts
    for (name, _), members in sweeps.items():
        differ = [len(set(column)) > 1 for column in zip(*members.values(), strict=True)]
        if any(differ) and max(map(len, members)) > at_most:
            kept = {label: [*compress(parts, differ)] for label, parts in members.items()}
            if max(len(",".join(parts)) for parts in kept.values()) > at_most - 5:
                kept = {label: [part.partition("=")[2] or part for part in parts] for label, parts in kept.items()}
            short = {label: ",".join(parts) for label, parts in kept.items()}
            room = at_most - 2 - max(map(len, short.values()))
            texts |= {label: f"{plain(name, room)}[{own}]" if room > 2 else own for label, own in short.items()}
    return texts


def letters(width: float, points: float = POINTS) -> int:
    """Return about how many letters fit above a panel of a width in inches, beyond which a title may reach a little."""
    return max(int((width + 0.2) * 72 / (0.6 * points)), 8)


def title(ax: Axes, text: str, at_most: int = 28) -> None:
    """Write a title above a panel, in one line that it has room for."""
    ax.set_title(plain(text, min(at_most, letters(inches(ax)))), loc="left")


def inches(ax: Axes) -> float:
    """Return the width of a panel in inches."""
    return float(ax.get_window_extent().width / ax.figure.dpi)


def text_width(texts: Iterable[str], points: float = POINTS, *, bold: bool = True) -> float:
    """Return the width in inches of the widest text, 0 without any; a letter that the font lacks counts as square.

    Margins have room for ``bold`` letters, as the name of a subject is written.
    """
    font = FontProperties(family="sans-serif", size=points, weight="bold" if bold else "normal")
    widest = 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of letters that the font lacks
        for text in texts:
            width, _, _ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
            square = sum(unicodedata.east_asian_width(letter) in "WF" for letter in text)
            widest = max(widest, width + 0.4 * points * square)  # a browser draws them 1 em wide, not 0.6
    return widest / 72


def own_axes(ax: Axes | None, *, height: float = 2.2) -> Axes:
    """Return the Axes given, or those of a new pyplot figure a column wide, which a notebook shows by itself."""
    if ax is not None:
        return ax
    from matplotlib import pyplot  # imported here, as a report opens no window

    _, ax = pyplot.subplots(figsize=(COLUMN, height), layout="constrained")
    return ax


def grid(
    number: int, *, columns: int = 3, width: float | None = None, height: float, left: float,
    bottom: float = 0.36, top: float = 0.2, across: float = 0.0, down: float = 0.0,
) -> tuple[matplotlib.figure.Figure, list[Axes]]:  # fmt: skip
    """Return a figure of small multiples and its axes, row by row, laid out by known margins.

    All lengths are in inches: the figure's ``width``, by default that of the page, the ``height`` of one panel, the
    figure's margins, and the space ``across`` and ``down`` between panels.
    """
    width = PAGE if width is None else width
    columns = max(min(columns, number), 1)
    rows = max(ceil(number / columns), 1)
    total = rows * height + (rows - 1) * down + top + bottom
    panel = max((width - left - RIGHT - (columns - 1) * across) / columns, 0.1)
    figure = matplotlib.figure.Figure(figsize=(width, total))
    figure.subplots_adjust(
        left / width, bottom / total, left / width + (columns * panel + (columns - 1) * across) / width,
        1 - top / total, wspace=across / panel, hspace=down / height,
    )  # fmt: skip
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for unused in axes[number:]:
        unused.remove()
    for ax in axes[:number]:  # where labels stay, nobody has to look for free places
        ax.xaxis.set_label_coords(0.5, -X_LABEL / height)
        ax.yaxis.set_label_coords((Y_LABEL - left) / panel, 0.5)
    return figure, list(axes[:number])


def rows_height(count: int) -> float:
    """Return the height in inches of ``count`` labelled rows, a page at most."""
    return min(ROW * max(count, 1) + 0.1, TALLEST)


def name_rows(ax: Axes, names: Sequence[str]) -> range:
    """Name the rows 0, 1, … of an Axes from the top, only every n-th where rows are narrow; return the rows named."""
    inches = ax.get_window_extent().height / ax.figure.dpi
    step = max(ceil(len(names) * 0.115 / inches), 1)  # inches of a line of small text
    named = range(0, len(names), step)
    ax.set_yticks(named, [names[row] for row in named])
    ax.set_ylim(max(len(names), 1) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0)
    ax.grid(visible=False, axis="y")
    return named


def handles(pens: Pens) -> list[Line2D]:
    """Return the legend entries of the first :data:`MANY_NAMES` optimizers, and how many more there are."""
    coloured = {label: pen for label, pen in pens.items() if not pen.background}
    shown = list(zip(names(coloured).values(), coloured.values(), strict=True))[:MANY_NAMES]
    entries = [
        Line2D([], [], color=pen.color, linestyle=pen.line, linewidth=1.2, marker=pen.marker, markersize=3.5,
               label=name)
        for name, pen in shown
    ]  # fmt: skip
    if grey := len(pens) - len(coloured):
        entries.append(Line2D([], [], color=GREY, linewidth=1.2, label=f"{grey} others"))
    if left_out := len(coloured) - len(shown):
        entries.append(Line2D([], [], linestyle="none", label=f"and {left_out} more"))
    return entries


def legend_above(figure: matplotlib.figure.Figure, entries: Sequence[Artist]) -> None:
    """Put a legend of labelled artists above all panels of a figure."""
    columns = _legend_columns([str(entry.get_label()) for entry in entries], figure.get_figwidth())
    figure.legend(handles=entries, loc="upper left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2)


def legend_height(texts: Sequence[str]) -> float:
    """Return the height in inches of a :func:`legend_above` with these texts, in a figure as wide as a page's text."""
    return LEGEND_ROW * ceil(len(texts) / _legend_columns(texts, PAGE)) + 0.08


def _legend_columns(texts: Sequence[str], width: float) -> int:
    return max(min(int((width - 0.1) / (text_width(texts, SMALL, bold=False) + 0.45)), len(texts)), 1)


def spread(count: int) -> np.ndarray:
    """Return (count,) offsets within +-0.25 that keep neighbouring points apart, the same every time."""
    golden = 0.6180339887498949
    return ((np.arange(count) * golden) % 1 - 0.5) / 2


def drawable(values: ArrayLike) -> NDArray[np.bool_]:
    """Return flags of the values that an axis can show: finite ones smaller than :data:`HUGE`."""
    sizes: NDArray[np.float64] = np.abs(np.asarray(values, dtype=np.float64))
    return sizes < HUGE


def log_scale(ax: Axes, which: Literal["x", "y"]) -> None:
    """Make an axis logarithmic after drawing, with ticks also at 2 and 5 where it spans little.

    Its numbers are plain, or all powers where some would be too long.
    """
    getattr(ax, f"set_{which}scale")("log")
    low, high = sorted(getattr(ax, f"get_{which}lim")())
    if low <= 0:  # the limits around curves without any point, which a log axis cannot draw
        low, high = getattr(ax, f"set_{which}lim")(1.0, 10.0)
    axis = ax.xaxis if which == "x" else ax.yaxis
    room = inches(ax) if which == "x" else TALLEST
    most = max(min(int(room / TICK), 6), 2)
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100 * low else (1.0,), numticks=most))
    axis.set_major_formatter(FuncFormatter(partial(_number, as_power=high >= 1e6 or low < 1e-4)))
    axis.set_minor_locator(NullLocator())


def span(ax: Axes, values: pd.Series[float]) -> None:
    """Limit an x axis to the range of the values on it; matplotlib chooses the limits about a single value."""
    if values.nunique() > 1:
        ax.set_xlim(values.min(), values.max())


def linear_scale(ax: Axes, which: Literal["x", "y"]) -> None:
    """Give a linear axis few ticks, as small panels need."""
    (ax.xaxis if which == "x" else ax.yaxis).set_major_locator(MaxNLocator(4))


def fitting_scale(ax: Axes, which: Literal["x", "y"], values: ArrayLike, ratio: float = WIDE) -> None:
    """Make an axis logarithmic where its values are positive and span a factor above ``ratio``, else linear."""
    shown = np.asarray(values, dtype=float)
    shown = shown[drawable(shown)]
    wide = len(shown) and shown.min() > 0 and shown.max() > ratio * shown.min()
    (log_scale if wide else linear_scale)(ax, which)


def _number(value: float, _: int | None, as_power: bool) -> str:
    """Return the text of a tick: 1,000 or 0.01, or as a power, 10⁷ or 2×10⁻⁵."""
    if not as_power:
        return f"{value:,.0f}" if value >= 1e3 else f"{value:g}"
    digits, power = f"{value:e}".split("e")
    factor = "" if float(digits) == 1 else f"{float(digits):g}×"
    return f"{factor}10{str(int(power)).translate(SUPERSCRIPTS)}"


def rows_of(frame: pd.DataFrame, problem: str) -> pd.DataFrame:
    """Return the rows of a problem.

    Raises:
        BenchError: the frame does not know the problem; a misspelt label would otherwise draw nothing.
    """
    problems = labels(frame, "problem")
    if problem not in problems:
        raise BenchError(f"there is no problem {problem!r} to draw{nearest(problem, problems)}")
    return frame[frame["problem"] == problem]
