"""The targets reached over evaluations as a Vega-Lite specification: a reader chooses problem, target and curves."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from bench.plots import style
from bench.topics.findings import Findings
from bench.typing import Floats

MOST_ROWS = 100_000  # of the data inside the page, about 2 MB
STEPS = 60  # budgets to which evaluations are rounded up
EVERY = -1  # in place of the number of a problem or of a target
INK = "#000000"  # drawn in the colour of the page's text, so that it can be seen on a dark page
DASHES: dict[Any, list[int]] = {"-": [1, 0], "--": [6, 3], "-.": [6, 3, 2, 3], ":": [2, 3], (0, (5, 1)): [9, 2]}
"""The line styles of :mod:`bench.plots.style` in Vega's terms."""
TITLE = "Share of targets reached by the trials"
HINT = [
    "Choose problem and target; click a name for its curve alone.",
    "Ctrl and the wheel zoom, dragging moves, a double click goes back.",
]


def targets_reached(findings: Findings) -> dict[str, Any] | None:
    """Return the specification; None where no problem has targets, or too much data would be inside the page."""
    table, along = _counts(findings)
    if table.empty or len(table) > MOST_ROWS:
        return None
    chosen = findings.anytime.target_set
    problems = {"all problems": EVERY} | {label: i for i, label in enumerate(findings.trials.problems)}
    targets = {"all targets": EVERY} | {_at(findings, tau): i for i, tau in enumerate(chosen.tabled)}
    shown = {"condition": {"param": "curve", "value": 1}, "value": 0.1}
    x_axis = {"title": along, "format": "~g", "labelOverlap": True, "tickCount": 6}
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
            {"joinaggregate": [{"op": "sum", "field": "of", "as": "all"}], "groupby": ["o"]},
            {
                "window": [{"op": "sum", "field": "reached", "as": "so_far"}],
                "sort": [{"field": "e"}],
                "groupby": ["o"],
            },
            {"calculate": "datum.all > 0 ? datum.so_far / datum.all : null", "as": "share"},
        ],
        "mark": {"type": "line", "interpolate": "step-after", "clip": True},
        "encoding": {
            "x": {"field": "e", "type": "quantitative", "scale": {"type": "log", "nice": False}, "axis": x_axis},
            "y": {"field": "share", "type": "quantitative", "scale": {"domain": [0, 1]}, "axis": y_axis},
            "opacity": shown,
            **_pens(findings.display.drawn),
        },
        "config": {
            "view": {"stroke": None},
            "title": {"color": "currentColor", "subtitleColor": "currentColor", "subtitleFontSize": 10},
            "axis": {"gridOpacity": 0.15, "titleFontWeight": "normal", "labelFontSize": 11, "titleFontSize": 11}
            | {f"{part}Color": "currentColor" for part in ("domain", "grid", "label", "tick", "title")},
            "legend": {"labelColor": "currentColor", "labelLimit": 240, "orient": "bottom", "columns": 3},
        },
    }  # fmt: skip


def _choice(name: str, title: str, options: Mapping[str, int]) -> dict[str, Any]:
    bind = {"input": "select", "name": title, "options": list(options.values()), "labels": list(options)}
    return {"name": name, "value": EVERY, "bind": bind}


def _pens(pens: style.Pens) -> dict[str, Any]:
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


def _at(findings: Findings, tau: float) -> str:
    chosen = findings.anytime.target_set
    return chosen.at(1 / tau if chosen.rising else tau)


def _counts(findings: Findings) -> tuple[pd.DataFrame, str]:
    """Return how often targets were reached when, and the title of the axis of evaluations.

    Columns: numbers of optimizer, problem and target (o, p, t; targets that no table has count together), evaluations
    (e), in how many pairs of a trial and a target it was then reached, and of how many pairs (of), once a cell and
    target. Evaluations are counted by dimension where budgets differ.
    """
    trials, names, tabled = findings.trials, list(findings.display.drawn), np.array(findings.anytime.target_set.tabled)
    hits = findings.anytime.hits
    hits = hits[hits["optimizer"].isin(names)].reset_index(drop=True)
    if hits.empty:
        return hits, ""
    scaled = trials.scaled and trials.dimensions.keys() >= set(trials.problems)
    sizes = trials.dimensions if scaled else dict.fromkeys(trials.problems, 1)
    codes, taus = pd.factorize(hits["tau"].to_numpy(dtype=float))
    same = np.isclose(taus[:, np.newaxis], tabled, rtol=1e-9, atol=0)
    target = np.where(same.any(axis=1), same.argmax(axis=1), len(tabled))
    own = pd.DataFrame(
        {"o": _places(hits["optimizer"], names), "p": _places(hits["problem"], trials.problems), "t": target[codes]}
    )
    keys = list(own)
    evaluations = hits["evaluations"].to_numpy(float) / hits["problem"].astype(object).map(sizes).to_numpy(float)
    end = max(budget / sizes[label] for label, budget in trials.budgets.items())
    finite = np.isfinite(evaluations)
    first = min(evaluations[finite].min(initial=end), end / 10)
    grid: Floats = np.geomspace(first, end, STEPS)
    rounded = grid[np.searchsorted(grid * (1 + 1e-9), evaluations[finite]).clip(max=STEPS - 1)]
    begun = own.groupby(keys).size().rename("of").reset_index().assign(e=first)
    when = own[finite].assign(e=rounded).groupby([*keys, "e"]).size().rename("reached").reset_index()
    ended = own.drop_duplicates().assign(e=end)
    table = pd.concat([begun, when, ended])[[*keys, "e", "reached", "of"]].fillna(0)
    table["e"] = [float(f"{each:.4g}") for each in table["e"]]
    return table.astype({"reached": int, "of": int}), "evaluations / d" if scaled else "evaluations"


def _places(labels: pd.Series[Any], order: Sequence[str]) -> Any:
    return labels.astype(object).map({label: i for i, label in enumerate(order)}).to_numpy(int)
