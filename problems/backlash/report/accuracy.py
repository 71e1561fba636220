"""The parts of Figs. 7.3 and 7.4: values found beside the true ones, and panels with the datasets on their x axis."""

from __future__ import annotations

import re
from math import ceil
from typing import Any

import matplotlib.figure
import pandas as pd
from matplotlib.axes import Axes

from bench.plots import style
from bench.report import listing, speaker
from bench.topics import StoredResults

SAY = speaker(__package__)
LEFT, ACROSS = 0.45, 0.1  # inches
LABEL = 18  # characters of a dataset's name, such as "noisy-02 high"


def expected_values(results: StoredResults) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return problem, metric, expected value and tolerance of every known truth, in the study's order.

    The second part says by problem why its truth is not known here: its data changed, or its plug-in is missing.
    """
    rows, unknown = [], {}
    for entry in results.study.problems:
        facts = results.facts(entry.label)
        rows += [(entry.label, figure, value, tolerance) for figure, (value, tolerance) in facts.expected.items()]
        if facts.reason:
            unknown[entry.label] = facts.reason
    truths = pd.DataFrame(rows, columns=["problem", "figure", "expected", "tolerance"])
    return truths.astype({"expected": float, "tolerance": float}), unknown


def estimates(frame: pd.DataFrame, truths: pd.DataFrame, figure: str) -> pd.DataFrame:
    """Return a row a trial of the problems that have the metric: the value found, the expected one and the error.

    Args:
        frame: the tidy frame, in the study's order.
        truths: from :func:`expected_values`.
        figure: the metric, such as ``"amplitude_rpm"``; all numbers are in its unit.

    Columns: problem, optimizer, trial, status, figure, found, expected, tolerance, error (found - expected), and
    within, whether the error is within the tolerance. A trial that failed or found no value is not within.
    """
    truth = truths[truths["figure"] == figure].set_index("problem")
    problem = frame["problem"].astype(object)
    values = pd.to_numeric(frame[figure]).astype(float).where(frame["status"] == "ok")
    expected, tolerance = (problem.map(truth[column]).astype(float) for column in ("expected", "tolerance"))
    error = values - expected
    data = frame[["problem", "optimizer", "trial", "status"]].assign(
        figure=figure,
        found=values,
        expected=expected,
        tolerance=tolerance,
        error=error,
        within=error.abs() <= tolerance,
    )
    return _of_problems(data, problem[values.notna() | expected.notna()])


def with_truth(data: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the problems whose truth is known."""
    return _of_problems(data, data.loc[data["expected"].notna(), "problem"])


def _of_problems(data: pd.DataFrame, problems: pd.Series[Any]) -> pd.DataFrame:
    data = data[data["problem"].isin(set(problems))]
    return data.assign(problem=data["problem"].cat.remove_unused_categories())


def errors_by(data: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return trials, mean and median error, the median of its size, and the percentage of trials within the tolerance.

    One row for each value of ``keys``. Signed errors show which way an optimizer errs; over- and underestimates cancel
    in them, so that a wide scatter about the truth looks accurate: only the size shows how far off a trial is.
    Only trials with a known truth count. Errors are over the trials that found a value, the percentage is over all.
    """
    trials = with_truth(data)
    groups = trials.assign(size=trials["error"].abs()).groupby(keys, observed=True)
    errors = groups["error"].agg(["size", "mean", "median"]).set_axis(["trials", "mean error", "median error"], axis=1)
    return errors.assign(**{"median |error|": groups["size"].median(), "within band %": 100 * groups["within"].mean()})


def signed_and_size(data: pd.DataFrame, unit: str, factor: float = 1.0) -> str:
    """Return a sentence on the most accurate by the signed median error and by its size; "" if both are the same.

    ``factor`` converts the errors to the ``unit``, such as " rpm", which follows the numbers.
    """
    errors = errors_by(data, ["optimizer"]).dropna()
    signed, size = factor * errors["median error"], factor * errors["median |error|"]
    if len(errors) < 2:
        return ""
    one, best, worst = (str(sizes.idxmin()) for sizes in (signed.abs(), size, -size))
    return "" if one == best else SAY("signed_and_size", one, best, signed, size, unit, one == worst)


def expected_by_problem(data: pd.DataFrame) -> pd.DataFrame:
    """Return the expected value and tolerance of each problem, missing where not known, in the study's order."""
    return data.groupby("problem", observed=False)[["expected", "tolerance"]].first()


def shares_within(data: pd.DataFrame) -> str:
    """Return the share of each optimizer's trials within the tolerance, the best first, such as "43% of gwo trials"."""
    shares = errors_by(data, ["optimizer"])["within band %"].sort_values(ascending=False, kind="stable")
    return listing([f"{share:.0f}% of {label} trials" for label, share in shares.items()])


def dataset_panels(
    titles: list[str], problems: list[str], entries: list[str], *, columns: int, height: float
) -> tuple[matplotlib.figure.Figure, list[Axes]]:
    """Return a figure as wide as the text and its titled axes, row by row, with the datasets at 0, 1, … of the x axis.

    Args:
        titles: a title for each panel; panels side by side share their y axis.
        problems: the labels of the datasets.
        entries: the texts of the legend above all panels (:func:`bench.plots.style.legend_above`), at most.
        columns: panels in a row.
        height: of a panel in inches.
    """
    names = [style.plain(short(problem), LABEL) for problem in problems]
    longest, digits = style.text_width(names), style.text_width(["00"])
    upright, columns = longest <= digits, min(columns, len(titles))
    figure, axes = style.grid(
        len(titles), columns=columns, height=height, left=LEFT, bottom=0.36 + (0 if upright else longest),
        top=0.25 + style.legend_height(entries), across=ACROSS, down=0.3,
    )  # fmt: skip
    width = (style.PAGE - LEFT) / columns - ACROSS
    every = ceil(len(names) * (longest + 0.06 if upright else 0.12) / width)
    for number, (ax, title) in enumerate(zip(axes, titles, strict=True)):
        if number:
            ax.sharex(axes[0])
        if number and columns > 1:
            ax.sharey(axes[0])
            ax.tick_params(axis="y", labelleft=number % columns == 0)
        style.title(ax, title)
        ax.grid(visible=False, axis="x")
        last = number >= len(axes) - columns
        ax.tick_params(axis="x", rotation=0 if upright else 90, labelbottom=last)
        if last:
            ax.set_xlabel("dataset")
    axes[0].set_xticks(range(0, len(names), every), names[::every])
    axes[0].set_xlim(-0.7, len(names) - 0.3)
    return figure, axes


def short(problem: str) -> str:
    """Return the number of a simulated or published dataset, any other label unchanged."""
    return re.sub(r"^(signature|published)-0*(?=\d+$)", "", problem)
