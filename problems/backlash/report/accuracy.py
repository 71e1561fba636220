"""Compare the values that trials found with the true ones, where these are known."""

from __future__ import annotations

from typing import Any

import pandas as pd

from bench import Results
from bench.analysis import labels
from bench.report.wording import listing

COLUMNS = (
    "problem", "optimizer", "trial", "status", "figure", "found", "expected", "tolerance", "error", "within",
)  # fmt: skip


def expected_values(results: Results) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return problem, metric, expected value and tolerance of every known truth, in the study's order.

    The second part says by problem why its truth is not known here: its data changed, or its plug-in is missing.
    """
    rows, unknown = [], {}
    for entry in results.study.problems:
        known = results.facts(entry.label)
        rows += [(entry.label, figure, value, tolerance) for figure, (value, tolerance) in known.expected.items()]
        if known.reason:
            unknown[entry.label] = known.reason
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
    known = truths[truths["figure"] == figure].set_index("problem")
    problem = frame["problem"].astype(object)
    found = pd.to_numeric(frame[figure]).astype(float).where(frame["status"] == "ok")
    expected, tolerance = (problem.map(known[column]).astype(float) for column in ("expected", "tolerance"))
    error = found - expected
    data = frame.assign(
        figure=figure, found=found, expected=expected, tolerance=tolerance, error=error, within=error.abs() <= tolerance
    )[list(COLUMNS)]
    return _of_problems(data, problem[found.notna() | expected.notna()])


def with_truth(data: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the problems whose truth is known."""
    return _of_problems(data, data.loc[data["expected"].notna(), "problem"])


def _of_problems(data: pd.DataFrame, problems: pd.Series[Any]) -> pd.DataFrame:
    data = data[data["problem"].isin(set(problems))]
    return data.assign(problem=data["problem"].cat.remove_unused_categories())


def errors_by(data: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return trials, mean and median error, and the percentage of trials within the tolerance, by ``keys``.

    Only trials with a known truth count. Errors are over the trials that found a value, the percentage is over all.
    """
    groups = with_truth(data).groupby(keys, observed=True)
    return pd.DataFrame(
        {
            "trials": groups["within"].size(),
            "mean error": groups["error"].mean(),
            "median error": groups["error"].median(),
            "within band %": 100 * groups["within"].mean(),
        }
    )


def expected_by_problem(data: pd.DataFrame) -> pd.DataFrame:
    """Return the expected value and tolerance of each problem, missing where not known, in the study's order."""
    known = data.groupby("problem", observed=False)[["expected", "tolerance"]].first()
    return known.reindex(labels(data, "problem"))


def shares_within(data: pd.DataFrame) -> str:
    """Return the share of each optimizer's trials within the tolerance, the best first, such as "43% of gwo trials"."""
    shares = errors_by(data, ["optimizer"])["within band %"].sort_values(ascending=False, kind="stable")
    return listing([f"{share:.0f}% of {label} trials" for label, share in shares.items()])
