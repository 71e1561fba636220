"""The expected time to targets with several workers, and where the order of the optimizers changes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd

from bench import analysis
from bench.analysis.parallel import parallel_ranks
from bench.plots import fastest_map, style
from bench.report.parts import Figure, Section, Table
from bench.report.wording import count
from bench.topics.figures import figure_width
from bench.topics.findings import Findings
from bench.topics.topic import Topic

TITLE = "Time with several workers"

MEANING = (
    "Where an evaluation takes long and several can be made at a time, an optimizer that asks for many points at once "
    "profits. The expected time to a target follows from the evaluations of each trial, the calls of the objective in "
    "which it made them, and the time that the optimizer itself took here: a call of n points takes n / p turns of p "
    "workers, rounded up. Ranks are means over problems and targets; they describe these trials, and no test is behind "
    "them."
)


def section(findings: Findings) -> Section | None:
    """Return the expected times by cost and workers; None without two optimizers whose calls are known."""
    times = findings.of(_times)
    ranks = parallel_ranks(times)
    if ranks.empty or ranks["optimizer"].nunique() < 2:
        return None
    figure, (ax,) = style.grid(1, width=figure_width(0.6), height=2.2, left=0.6, bottom=0.4, top=0.1)
    fastest_map(ranks, ax=ax)
    caption = "The optimizer with the lowest mean rank of its expected time, by seconds of an evaluation and workers."
    return Section(
        TITLE, (MEANING, order_changes(ranks)), (Figure("fastest-map", caption, figure, ranks), _table(ranks, times)),
        on_demand=True,
    )  # fmt: skip


def _times(findings: Findings) -> pd.DataFrame:
    """Return the expected times to the targets of the tables."""
    return analysis.parallel_times(findings.anytime.tabled_hits, findings.trials.whole)


def order_changes(ranks: pd.DataFrame) -> str:
    """Return a sentence on the optimizer of the lowest rank, and on the costs and workers at which it changes."""
    wide = ranks.pivot_table(
        index=["workers", "seconds"], columns="optimizer", values="rank", sort=False, observed=True
    )
    first: pd.DataFrame = wide.idxmin(axis=1).unstack("seconds").sort_index()
    names = pd.unique(first.to_numpy().ravel())
    costs, workers = [*first.columns], [*first.index]
    if len(names) == 1:
        return (
            f"{names[0]} has the lowest rank at every cost from {_cost(costs[0])} to {_cost(costs[-1])} an evaluation, "
            f"with {workers[0]} to {count(workers[-1], 'worker')}."
        )
    dearest = _spans(first[costs[-1]], str, "with", "worker")
    cheapest = _spans(first.loc[workers[0]], _cost, "at", "an evaluation")
    return (
        f"The order changes. With evaluations of {_cost(costs[-1])}, the lowest rank is that of {dearest}. With one "
        f"worker, it is that of {cheapest}."
    )


def _spans(first: pd.Series[str], text: Callable[[Any], str], word: str, unit: str) -> str:
    """Return the first along an axis, such as ``"gwo with 1 to 8 workers, then cma-es with 16 to 64 workers"``."""
    spans: list[tuple[str, list[Any]]] = []
    for place, name in first.items():
        if not spans or spans[-1][0] != name:
            spans.append((str(name), []))
        spans[-1][1].append(place)
    parts = []
    for name, places in spans:
        ends = [text(place) for place in dict.fromkeys((places[0], places[-1]))]
        parts.append(f"{name} {word} {' to '.join(ends)} {unit}" + "s" * (unit == "worker" and ends != ["1"]))
    return ", then ".join(parts)


def _table(ranks: pd.DataFrame, times: pd.DataFrame) -> Table:
    """Return the ranks by workers where an evaluation takes a second."""
    shown = ranks[ranks["seconds"] == 1.0].pivot(index="optimizer", columns="workers", values="rank")
    shown = shown.loc[ranks["optimizer"].drop_duplicates()]
    caption = "Mean rank of the expected time, by the number of workers, where an evaluation takes a second."
    note = "The file has the expected time to each target, for all workers and costs."
    return Table("parallel-ranks", caption, shown.rename(columns=str), decimals=2, note=note, data=times)


def _cost(seconds: float) -> str:
    return f"{seconds / 60:g} min" if seconds >= 60 else f"{seconds:g} s" if seconds >= 1 else f"{1000 * seconds:g} ms"


TOPIC = Topic(TITLE, section, place=695)
