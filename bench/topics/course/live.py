"""The targets reached over evaluations as a Vega-Lite specification: a reader chooses problem, target and curves."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import prod

import numpy as np
import pandas as pd
from matplotlib.typing import LineStyleType

from bench.helpers.parsing import JsonObject
from bench.plots import style
from bench.plots.curves import AXES
from bench.topics.course.curves import Compared, compared, curves, span
from bench.topics.findings import Findings

MOST_ROWS = 100_000  # of the data inside the page, about 2 MB
EVERY = -1  # in place of the number of a problem or of a target
INK = "#000000"  # drawn in the colour of the page's text, so that it can be seen on a dark page
DASHES: dict[LineStyleType, list[int]] = {
    "-": [1, 0], "--": [6, 3], "-.": [6, 3, 2, 3], ":": [2, 3], (0, (5, 1)): [9, 2],
}  # fmt: skip
"""The line styles of :mod:`bench.plots.style` in Vega's terms."""
TITLE = "The same curves, of a problem and a target"
HINT = [
    "Choose problem and target; click a name for its curve alone.",
    "Ctrl and the wheel zoom, dragging moves, a double click goes back.",
]


def targets_reached(findings: Findings) -> JsonObject | None:
    """Return the specification; None where no problem has targets, or too much data would be inside the page."""
    found = findings.of(compared)
    table, grid = _counts(findings, found), [float(f"{each:.4g}") for each in found.grid]
    if table.empty or len(table) > MOST_ROWS:
        return None
    chosen = findings.anytime.target_set
    problems = {"all problems": EVERY} | {label: i for i, label in enumerate(findings.trials.problems)}
    targets = {"all targets": EVERY} | {chosen.at(tau): i for i, tau in enumerate(chosen.tabled)}
    shown = {"condition": {"param": "curve", "value": 1}, "value": 0.1}
    x_axis = {"title": AXES[found.unit], "format": "~g", "labelOverlap": True, "tickCount": 6, "grid": False}
    x_scale = {"type": "log", "nice": False, "domain": span(findings.of(curves), found.unit)}
    y_axis = {"title": None, "format": ".0%", "tickCount": 5}
    return {
        "$schema": "https://vega.github.io/schema/vega-lite/v6.json",
        "width": "container",
        "height": 320,
        "background": "transparent",
        "title": {"text": TITLE, "subtitle": HINT, "anchor": "start", "fontSize": 12},
        "data": {"values": [table.to_dict("list")]},  # of CSV, Vega makes a function, which the page's policy refuses
        "params": [
            _choice("problem", "Problem ", problems),
            _choice("target", "Target ", targets),
            {"name": "curve", "select": {"type": "point", "fields": ["o"]}, "bind": "legend"},
            {"name": "zoom", "select": {"type": "interval", "zoom": "wheel![event.ctrlKey]"}, "bind": "scales"},
        ],
        "transform": [
            {"flatten": list(table)},
            {"filter": f"(problem == {EVERY} || datum.p == problem) && (target == {EVERY} || datum.t == target)"},
            {"joinaggregate": [{"op": "sum", "field": "of", "as": "all"}], "groupby": ["o", "p"]},
            {"joinaggregate": [{"op": "distinct", "field": "p", "as": "problems"}], "groupby": ["o"]},
            {"calculate": "datum.all > 0 ? datum.reached / datum.all / datum.problems : 0", "as": "step"},
            {"window": [{"op": "sum", "field": "step", "as": "share"}], "sort": [{"field": "e"}], "groupby": ["o"]},
            {"calculate": f"{json.dumps(grid)}[datum.e]", "as": "spent"},
        ],
        "mark": {"type": "line", "interpolate": "step-after", "clip": True},
        "encoding": {
            "x": {"field": "spent", "type": "quantitative", "scale": x_scale, "axis": x_axis},
            "y": {"field": "share", "type": "quantitative", "scale": {"domain": [0, 1]}, "axis": y_axis},
            "opacity": shown,
            **_pens({label: findings.display.pens[label] for label in findings.display.shown}),
        },
        "config": {
            "view": {"stroke": None},
            "title": {"color": "currentColor", "subtitleColor": "currentColor", "subtitleFontSize": 10},
            "axis": {"gridOpacity": 0.15, "titleFontWeight": "normal", "labelFontSize": 11, "titleFontSize": 11}
            | {f"{part}Color": "currentColor" for part in ("domain", "grid", "label", "tick", "title")},
            "legend": {"labelColor": "currentColor", "labelLimit": 240, "orient": "bottom", "columns": 3},
        },
    }  # fmt: skip


def _choice(name: str, title: str, options: Mapping[str, int]) -> JsonObject:
    bind = {"input": "select", "name": title, "options": list(options.values()), "labels": list(options)}
    return {"name": name, "value": EVERY, "bind": bind}


def _pens(pens: style.Pens) -> JsonObject:
    """Return the colours and lines of optimizers, which the data have by number, with one legend for both."""
    labels = [style.plain(label).replace("\\$", "$") for label in pens]
    legend = {"title": None, "labelExpr": f"{json.dumps(labels)}[datum.value]", "symbolType": "stroke"}
    ranges = {
        "color": ["currentColor" if pen.color == INK else pen.color for pen in pens.values()],
        "strokeDash": [DASHES[pen.line] for pen in pens.values()],
    }
    return {
        channel: {
            "field": "o",
            "type": "nominal",
            "scale": {"domain": list(range(len(pens))), "range": values},
            "legend": legend,
        }
        for channel, values in ranges.items()
    }


def _counts(findings: Findings, found: Compared) -> pd.DataFrame:
    """Return how often targets were reached when, as whole numbers.

    Columns: numbers of optimizer, problem and target (o, p, t; targets that no table has count together), the place of
    the evaluations on the grid (e), in how many pairs of a run and a target it was then reached, and of how many pairs
    (of), once a cell and target.
    """
    names, problems = findings.display.shown, findings.trials.problems
    hits, tabled = found.hits, np.array(findings.anytime.target_set.tabled)
    codes, taus = pd.factorize(hits["tau"].to_numpy(dtype=float))
    same = np.isclose(taus[:, np.newaxis], tabled, rtol=1e-9, atol=0)
    target = np.where(same.any(axis=1), same.argmax(axis=1), len(tabled))[codes]
    shape, size = (len(names), len(problems), len(tabled) + 1), len(found.grid)
    owner, problem = (
        pd.Categorical(hits[name], order).codes.astype(np.intp)
        for name, order in (("optimizer", names), ("problem", problems))
    )
    cell = np.ravel_multi_index((owner, problem, target), shape)
    spent = hits["evaluations"].to_numpy(float)
    if found.dimensions is not None:
        spent = spent / np.array([found.dimensions.get(label, np.nan) for label in problems])[problem]
    place = np.searchsorted(found.grid * (1 + 1e-9), spent)
    inside = place < size
    begin = int(place[inside].min(initial=size - 1))
    of = np.bincount(cell, minlength=prod(shape))
    reached = np.bincount(cell[inside] * size + place[inside], minlength=len(of) * size)
    there, when = np.flatnonzero(of), np.flatnonzero(reached)
    none, e = np.zeros_like(there), (max(begin - 1, 0) + 0 * there, when % size, size - 1 + 0 * there)
    keys = np.unravel_index(np.concatenate([there, when // size, there]), shape)
    return pd.DataFrame(
        dict(zip("opt", keys, strict=True))
        | {"e": np.concatenate(e), "reached": np.concatenate([none, reached[when], none])}
        | {"of": np.concatenate([of[there], 0 * when, none])}
    )
