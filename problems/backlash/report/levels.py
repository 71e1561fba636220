"""Fig. 7.3: the backlash of each dataset and the amplitude of its disturbance, and what the trials found of both."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from bench.analysis import labels
from bench.plots import style
from bench.report import Figure, Section, Table, count, listing
from problems.backlash.report import accuracy
from problems.backlash.signature.problem import TOLERANCE_RAD, TOLERANCE_RPM

TITLE = "Backlash and amplitude of the datasets (thesis Fig. 7.3)"
SHOWN = {"backlash_rad": ("Backlash δ", "1e-6 rad", 1e6), "amplitude_rpm": ("Amplitude |A|", "rpm", 1.0)}
WIDTH = 0.84  # of the place of a dataset
EXPECTED, BAND = "expected", "accuracy band"


def sections(frame: pd.DataFrame, truths: pd.DataFrame, unknown: dict[str, str]) -> list[Section]:
    """Return the section on Fig. 7.3, with a warning on the problems whose truth is not known."""
    every = {name: accuracy.with_truth(accuracy.estimates(frame, truths, name)) for name in SHOWN if name in frame}
    shown = {name: data for name, data in every.items() if len(data)}
    # a missing plug-in gives the same reason for all its problems
    reasons = {reason: [label for label, why in unknown.items() if why == reason] for reason in unknown.values()}
    warnings = tuple(
        f"The expected values of {listing(problems)} are not known here and left out: {reason}."
        for reason, problems in reasons.items()
    )
    if not shown:
        return [Section(TITLE, warnings=warnings)] if warnings else []
    text, items = smallest_step(truths), (_figure(shown),)
    if "backlash_rad" not in shown:
        return [Section(TITLE, text, items, warnings)]
    backlash = shown["backlash_rad"]
    text += (f"{accuracy.shares_within(backlash)} are within ±{TOLERANCE_RAD:g} rad of the true backlash.",)
    text += tuple(filter(None, [accuracy.signed_and_size(backlash, "e-6 rad", 1e6)]))
    if lost := int(backlash["found"].isna().sum()):
        why = "they failed, or the amplitude is outside the calibrated range"
        text += (f"{count(lost, 'trial')} of {len(backlash):,} gave no backlash: {why}.",)
    return [Section(TITLE, text, (*items, _table(backlash)), warnings)]


def smallest_step(truths: pd.DataFrame) -> tuple[str, ...]:
    """Return a sentence on the smallest step of the amplitude between neighbouring datasets, none without neighbours.

    It is the accuracy asked of A, as the step in backlash is the accuracy asked of delta (section 7.2.3).
    """
    table = truths.pivot(index="problem", columns="figure", values="expected")
    if not set(SHOWN) <= set(table):
        return ()
    steps = table.dropna().sort_values("backlash_rad").diff()
    neighbours = steps.loc[np.isclose(steps["backlash_rad"], 2 * TOLERANCE_RAD), "amplitude_rpm"]
    if neighbours.empty:
        return ()
    return (accuracy.SAY("smallest_step", 2 * TOLERANCE_RAD, neighbours.min(), neighbours.max(), 2 * TOLERANCE_RPM),)


def found_by_cell(data: pd.DataFrame) -> pd.DataFrame:
    """Return problem, optimizer, figure, expected, tolerance, trials, found (how many have a value), q1, median, q3."""
    groups = data.groupby(["problem", "optimizer"], observed=True)
    quartiles = groups["found"].quantile(np.array([0.25, 0.5, 0.75])).unstack()
    table = groups.agg(
        figure=("figure", "first"), expected=("expected", "first"), tolerance=("tolerance", "first"),
        trials=("trial", "size"), found=("found", "count"),
    )  # fmt: skip
    return table.assign(q1=quartiles[0.25], median=quartiles[0.5], q3=quartiles[0.75]).reset_index()


def _table(data: pd.DataFrame) -> Table:
    errors = accuracy.errors_by(data, ["optimizer"])
    errors[["mean error", "median error", "median |error|"]] *= 1e6
    return Table(
        "backlash-errors",
        f"Backlash error in 1e-6 rad (found less true), and the percentage of trials within ±{TOLERANCE_RAD:g} rad.",
        errors,
        decimals={"mean error": 1, "median error": 1, "median |error|": 1, "within band %": 1},
        note="Errors are over the trials that gave a backlash; the percentage is over all trials.",
    )


def _figure(shown: dict[str, pd.DataFrame]) -> Figure:
    cells = pd.concat([found_by_cell(data) for data in shown.values()], ignore_index=True)
    first = next(iter(shown.values()))
    optimizers, problems = labels(first, "optimizer"), labels(first, "problem")
    titles = ["{} in {}".format(*SHOWN[name]) for name in shown]
    names = [style.plain(optimizer) for optimizer in optimizers]
    figure, axes = accuracy.dataset_panels(titles, problems, [EXPECTED, BAND, *names], columns=1, height=1.7)
    pens = style.pens(optimizers).values()
    for ax, (name, data) in zip(axes, shown.items(), strict=True):
        scale = SHOWN[name][2]
        _truth(ax, accuracy.expected_by_problem(data).reindex(problems) * scale)
        marks = cells[cells["figure"] == name].astype({"problem": object, "optimizer": object})
        for number, (optimizer, pen, label) in enumerate(zip(optimizers, pens, names, strict=True)):
            table = scale * marks[marks["optimizer"] == optimizer].set_index("problem")[["q1", "median", "q3"]]
            table = table.reindex(problems)
            at = np.arange(len(problems)) + 0.9 * WIDTH * ((number + 0.5) / len(optimizers) - 0.5)
            ax.vlines(at, table["q1"], table["q3"], color=pen.color, linewidth=0.9)
            ax.plot(at, table["median"], pen.marker, color=pen.color, markersize=3, markeredgewidth=0, label=label)
    style.legend_above(figure, axes[0].get_legend_handles_labels()[0])
    caption = (
        "The true backlash of each dataset and the amplitude expected of it (lines; shaded: the accuracy bands), as in "
        "thesis Fig. 7.3, with the median (marker) and the quartiles (bar) of each optimizer’s trials."
    )
    return Figure("backlash-and-amplitude", caption, figure, cells, _abridged(cells))


def _truth(ax: Axes, truth: pd.DataFrame) -> None:
    """Draw each true value as wide as the marks on it, in grey, as the colours mean optimizers."""
    at, expected, tolerance = np.arange(len(truth)), truth["expected"], truth["tolerance"]
    ax.use_sticky_edges = False  # the end of a bar is no limit of the axis
    ax.bar(at, 2 * tolerance, WIDTH, expected - tolerance, color="0.85", label=BAND)
    ax.hlines(expected, at - WIDTH / 2, at + WIDTH / 2, color="0.2", linewidth=0.9, label=EXPECTED)


def _abridged(cells: pd.DataFrame) -> pd.DataFrame:
    """Return the truths and the medians, a row a problem."""
    columns: dict[str, pd.Series[float]] = {}
    for name, (title, unit, scale) in SHOWN.items():
        rows = cells[cells["figure"] == name]
        if rows.empty:
            continue
        columns[f"{title} in {unit}"] = scale * rows.groupby("problem", observed=True)["expected"].first()
        medians = scale * rows.pivot(index="problem", columns="optimizer", values="median")
        columns |= {f"{title}, {optimizer}": medians[optimizer] for optimizer in medians}
    return pd.DataFrame(columns).rename_axis("problem")
