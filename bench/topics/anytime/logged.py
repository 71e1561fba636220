"""Draw the values that optimizers log, such as step sizes, over the evaluations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench import analysis
from bench.objective import Trace
from bench.plots import convergence
from bench.report.parts import Section
from bench.report.wording import listing
from bench.topics.anytime.figures import over_evaluations
from bench.topics.findings import Findings

TITLE = "Inside the search"
NAMES, PROBLEMS = 6, 12  # that are drawn; the file has all


def section(findings: Findings) -> Section | None:
    """Return a figure for each name that an optimizer logged; None where none did."""
    logs = findings.results.logs
    logs = logs[logs["optimizer"].isin(findings.trials.optimizers)].dropna(subset="value")
    if logs.empty:
        return None
    names, problems = [*dict.fromkeys(logs["name"])], [*dict.fromkeys(logs["problem"])]
    figures = []
    for name in names[:NAMES]:
        of_name = logs[(logs["name"] == name) & logs["problem"].isin(problems[:PROBLEMS])]
        curves = _medians(of_name)
        caption = f"Median of {name}, as the optimizers logged it, over evaluations, with the quartiles as a band."

        def draw(frame: pd.DataFrame, problem: str, *, label: str = name, **looks: object) -> Axes:
            ax = convergence(frame, problem, **looks)  # type: ignore[arg-type]
            ax.set_ylabel(label)
            return ax

        figures.append(
            over_evaluations(f"logged-{name}", caption, draw, curves, [*dict.fromkeys(of_name["optimizer"])])
        )
    who = listing([*dict.fromkeys(logs["optimizer"])])
    some = f" The first {NAMES} of {len(names)} names are drawn." if len(names) > NAMES else ""
    few = f" The first {PROBLEMS} of {len(problems)} problems are drawn." if len(problems) > PROBLEMS else ""
    text = f"{who} logged {listing(names)} during the search. A trial keeps its last value.{some}{few}"
    return Section(TITLE, (text,), tuple(figures), on_demand=True)


def _medians(logs: pd.DataFrame) -> pd.DataFrame:
    """Return the median and the quartiles of one name over evaluations, infinite before most trials have logged it."""
    keys = ["problem", "optimizer", "trial"]
    traces: Any = {
        key: Trace(rows["evaluations"].to_numpy(), rows["value"].to_numpy())
        for key, rows in logs.groupby(keys, sort=False, observed=True)
    }
    frame = pd.DataFrame([*traces], columns=keys).assign(status="ok")
    grid = analysis.evaluation_grid(max(int(logs["evaluations"].max()), 1))
    return analysis.convergence(frame, traces, np.asarray(grid))
