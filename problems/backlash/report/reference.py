"""The reference fit: the best fit to each recording, and which trials found it."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from bench.analysis import labels, scores
from bench.report import Table
from bench.topics import StoredResults, repairing
from problems.backlash.report import words
from problems.backlash.report.accuracy import shares_within, with_truth
from problems.backlash.signature.problem import FOUND, TOLERANCE_RAD, TOLERANCE_RPM, SignatureFit

NAME, SHARE = "found", "best fit found %"
"""The name of the table, and its column of the shares of runs that found the best fit."""

BANDS = {
    "amplitude_rpm": ("amplitude", "|A| within band %", f"{TOLERANCE_RPM:.4f} rpm"),
    "backlash_rad": ("half-gap", "δ within band %", f"{TOLERANCE_RAD:g} rad"),
}
"""The words for each metric, the title of its column, and half of the accuracy asked for in section 7.2.1."""


def found_by_runs(
    results: StoredResults, frame: pd.DataFrame, found: Mapping[str, pd.DataFrame]
) -> tuple[list[str], list[Table]]:
    """Return the table of what the runs of each optimizer found, with sentences; none where nothing is known of it.

    ``found`` has the values of each metric beside the true ones (:func:`problems.backlash.report.accuracy.estimates`).
    """
    columns: dict[str, pd.Series[str] | pd.Series[float]] = {}
    said, problems = [], signature_problems(results, frame)
    if problems:
        every = all(problem.constrained for problem in problems.values())
        constrained = {label: kept or every for label, kept in repairing(results.study).items()}
        fits = reference_fits(problems, constraints=any(constrained.values()))
        trials = beside_reference(frame, fits, constrained)
        by_optimizer = trials.groupby("optimizer", observed=True)
        columns["ran under"] = pd.Series(
            {label: "constraints" if kept else "box" for label, kept in constrained.items()}
        )
        columns[SHARE] = 100 * by_optimizer["found"].mean()
        columns["median regret %"] = 100 * by_optimizer["excess"].median()
        said = [words.best_fit(in_words(by_optimizer["found"].mean()), FOUND), *_cost(fits, constrained, trials)]
    for figure, (what, title, band) in BANDS.items():
        if figure in found and len(with_truth(found[figure])):
            shares = shares_within(found[figure])
            columns[title] = 100 * shares
            said.append(words.within(what, in_words(shares), f"±{band}"))
    if not columns:
        return [], []
    rows = [label for label in labels(frame, "optimizer") if any(label in column for column in columns.values())]
    shown = pd.DataFrame(columns, index=pd.Index(rows, name="optimizer"))
    note = (
        "Over all trials; one that failed found nothing. Regret: against the best fit under what the trial ran under."
    )
    return said, [Table(NAME, "What the runs of each optimizer found.", shown, decimals=1, note=note)]


def in_words(shares: pd.Series[float]) -> list[str]:
    """Return the share of each optimizer's runs, the best first, such as "43% of gwo runs"."""
    return [
        f"{share:.0%} of {label} runs" for label, share in shares.sort_values(ascending=False, kind="stable").items()
    ]


def _cost(fits: pd.DataFrame, constrained: Mapping[str, bool], trials: pd.DataFrame) -> list[str]:
    """Return a sentence on what the constraints cost the best fit, none without an optimizer under them."""
    limited = [label for label in labels(trials, "optimizer") if constrained[label]]
    if not limited:
        return []
    cost = fits["constrained"] / fits["box"] - 1
    return [words.constraints(limited, int((cost > 1e-9).sum()), float(cost.max()), len(fits))]


def signature_problems(results: StoredResults, frame: pd.DataFrame) -> dict[str, SignatureFit]:
    """Return the signature problems of a frame that can be loaded, by label."""
    loaded = {
        label: results.problem(label).unscored for label in labels(frame, "problem") if not results.facts(label).reason
    }
    return {label: problem for label, problem in loaded.items() if isinstance(problem, SignatureFit)}


def reference_fits(problems: dict[str, SignatureFit], *, constraints: bool) -> pd.DataFrame:
    """Return by problem the RMSE of the best fit, inside the box and, with ``constraints``, under them too.

    Columns: box and constrained, in the problem's unit.
    """

    names = ("box", "constrained") if constraints else ("box",)
    values = {
        label: {name: problem.reference(constrained=name == "constrained").value for name in names}
        for label, problem in problems.items()
    }
    return pd.DataFrame(values).T.rename_axis("problem").reindex(columns=["box", "constrained"])


def beside_reference(frame: pd.DataFrame, fits: pd.DataFrame, constrained: dict[str, bool]) -> pd.DataFrame:
    """Return problem, optimizer, trial, excess and found of every trial on the problems of ``fits``.

    ``excess`` is the relative regret, (RMSE - best) / best, against the best fit under the constraints or in the box,
    as the trial ran. It is infinite for a trial that failed; ``found`` is excess <= ``FOUND``.
    """
    trials = frame[frame["problem"].isin(fits.index)]
    problem, limited = (
        trials["problem"].astype(object),
        trials["optimizer"].astype(object).map(constrained).astype(bool),
    )
    best = problem.map(fits["constrained"]).where(limited, problem.map(fits["box"])).astype(float)
    excess = scores(trials) / best - 1
    data = trials[["problem", "optimizer", "trial"]].assign(excess=excess, found=excess <= FOUND)
    return data.assign(problem=data["problem"].cat.remove_unused_categories())
