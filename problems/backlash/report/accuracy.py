"""Values that trials found beside the true ones."""

from __future__ import annotations

import pandas as pd

from bench.topics import StoredResults


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
    """Return a row for each trial of the problems that have the metric: the values found and expected, and the error.

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


def _of_problems(data: pd.DataFrame, problems: pd.Series[str]) -> pd.DataFrame:
    data = data[data["problem"].isin(set(problems))]
    return data.assign(problem=data["problem"].cat.remove_unused_categories())


def shares_within(data: pd.DataFrame) -> pd.Series[float]:
    """Return by optimizer the share of its trials within the tolerance; of those on problems with a known truth."""
    share: pd.Series[float] = with_truth(data).groupby("optimizer", observed=True)["within"].mean()
    return share
