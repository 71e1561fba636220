"""The reference fit: the best fit to each recording, and which trials found it."""

from __future__ import annotations

import math

import pandas as pd

from bench import Study
from bench.analysis import labels, scores
from bench.report import Section, Table
from bench.topics import StoredResults, repairing
from problems.backlash.report.accuracy import SAY
from problems.backlash.signature.model import TAU
from problems.backlash.signature.problem import FOUND, TOLERANCE_RPM, SignatureFit

TITLE = "Reference fit"
TITLES = {
    "box": "RMSE in the box", "constrained": "RMSE under the constraints", "box_rpm": "|A| in the box",
    "constrained_rpm": "|A| under the constraints", "expected_rpm": "expected |A|",
}  # fmt: skip
"""Titles of the columns of :func:`reference_fits`."""

AUTHORS = {0.0532785921510: 10, 0.1590388721814: 18, 0.1892322032210: 1, 0.1228865701909: 1}
"""RMSE in rps of the authors' 30 runs of CMA-ES on their recording of dataset 12, and how many runs ended there.

Outputs of the notebook in github.com/ElianaGiovannitti/Backlash-estimation (300 agents x 200 iterations, in the box).
"""


def sections(results: StoredResults, frame: pd.DataFrame) -> list[Section]:
    """Return the section on the reference fit, none for a study without a signature problem that can be loaded."""
    problems = signature_problems(results, frame)
    if not problems:
        return []
    trials, fits, constrained = compared(results, frame, problems)
    if trials.empty:
        return []
    text = tuple(filter(None, (*sentences(trials, fits, constrained), beside_authors(trials, results.study))))
    return [Section(TITLE, text, (_by_optimizer(trials, constrained), _by_dataset(trials), _fits(fits, problems)))]


def compared(
    results: StoredResults, frame: pd.DataFrame, problems: dict[str, SignatureFit]
) -> tuple[pd.DataFrame, pd.DataFrame, dict[str, bool]]:
    """Return the trials beside the best fits, these fits, and by optimizer whether it ran under the constraints."""
    every = all(problem.constrained for problem in problems.values())
    constrained = {label: kept or every for label, kept in repairing(results.study).items()}
    fits = reference_fits(problems, constraints=any(constrained.values()))
    return beside_reference(frame, fits, constrained), fits, constrained


def signature_problems(results: StoredResults, frame: pd.DataFrame) -> dict[str, SignatureFit]:
    """Return the signature problems of a frame that can be loaded, by label."""
    loaded = {
        label: results.problem(label).unscored for label in labels(frame, "problem") if not results.facts(label).reason
    }
    return {label: problem for label, problem in loaded.items() if isinstance(problem, SignatureFit)}


def reference_fits(problems: dict[str, SignatureFit], *, constraints: bool) -> pd.DataFrame:
    """Return by problem the RMSE of the best fit and its |A|, inside the box and, with ``constraints``, under them too.

    Columns: box and constrained (RMSE in the problem's unit), box_rpm, constrained_rpm and expected_rpm (|A|), and
    ``slack``, the factor by which |A| may change without changing the fit: A is the amplitude where the window begins,
    which may be anywhere between two samples.
    """

    def row(problem: SignatureFit) -> dict[str, float]:
        values = {
            "expected_rpm": problem.expected.get("amplitude_rpm", (math.nan,))[0],
            "slack": math.exp(float(problem.reference().x[TAU]) * problem.dt),
        }
        for name in ("box", "constrained") if constraints else ("box",):
            fit = problem.reference(constrained=name == "constrained")
            values |= {name: fit.value, f"{name}_rpm": problem.describe(fit.x)["amplitude_rpm"]}
        return values

    fits = pd.DataFrame({label: row(problem) for label, problem in problems.items()}).T.rename_axis("problem")
    return fits.reindex(columns=[*TITLES, "slack"])


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


def sentences(trials: pd.DataFrame, fits: pd.DataFrame, constrained: dict[str, bool]) -> list[str]:
    """Return sentences on who found the fit, what the constraints cost, and how near the fit is to the truth."""
    shares = _percent(trials, ["optimizer"]).sort_values(ascending=False, kind="stable")
    text = [SAY("found", [f"{share:.0f}% of {label} trials" for label, share in shares.items()], FOUND)]
    if limited := [label for label in shares.index if constrained[str(label)]]:
        cost = fits["constrained"] / fits["box"] - 1
        text.append(SAY("constraints", limited, cost[cost > 1e-9], len(fits)))
    truths = fits.dropna(subset="expected_rpm")
    if len(truths):
        near = int(((truths["box_rpm"] - truths["expected_rpm"]).abs() <= TOLERANCE_RPM).sum())
        text.append(SAY("truth", TOLERANCE_RPM, near, len(truths), truths["slack"].max() - 1))
    return text


def beside_authors(trials: pd.DataFrame, study: Study) -> str:
    """Return the authors' own runs on dataset 12 beside those of the study, "" without CMA-ES on it."""
    twelve = [entry.label for entry in study.problems if entry.name in ("signature-12", "published-12")]
    cma = [entry.label for entry in study.optimizers if entry.name == "cma-es"]
    shares = trials[trials["problem"].isin(twelve) & trials["optimizer"].isin(cma)]
    shares = _percent(shares, ["problem", "optimizer"]).reset_index()
    if shares.empty:
        return ""
    best = min(AUTHORS)
    elsewhere = [f"at {value:.4f} rps in {number}" for value, number in AUTHORS.items() if value > best]
    here = [f"{row.found:.0f}% of {row.optimizer} trials on {row.problem}" for row in shares.itertuples()]
    return SAY("authors", AUTHORS, best, elsewhere, here)


def _percent(trials: pd.DataFrame, keys: list[str]) -> pd.Series[float]:
    """Return the percentage of trials that found the fit, by ``keys``."""
    share: pd.Series[float] = 100 * trials.groupby(keys, observed=True)["found"].mean()
    return share


def _by_optimizer(trials: pd.DataFrame, constrained: dict[str, bool]) -> Table:
    groups = trials.groupby("optimizer", observed=True)
    shown = pd.DataFrame(
        {
            "trials": groups.size(),
            "found %": _percent(trials, ["optimizer"]),
            "median regret %": 100 * groups["excess"].median(),
        }
    )
    shown.insert(0, "ran under", ["constraints" if constrained[str(label)] else "box" for label in shown.index])
    return Table(
        "reference-fit-by-optimizer",
        f"Trials that found the best fit (an RMSE within {FOUND:.0%}), and the median regret in percent of its RMSE.",
        shown.rename_axis("optimizer"),
        decimals=1,
        note="Over all trials and datasets, against the best fit under the constraints or in the box, as given.",
    )


def _by_dataset(trials: pd.DataFrame) -> Table:
    return Table(
        "reference-fit-found",
        f"By dataset: percentage of trials that found the best fit (an RMSE within {FOUND:.0%}).",
        _percent(trials, ["problem", "optimizer"]).unstack("optimizer").rename_axis(columns=None),
        decimals=0,
    )


def _fits(fits: pd.DataFrame, problems: dict[str, SignatureFit]) -> Table:
    units = sorted({problem.unit for problem in problems.values()})
    return Table(
        "reference-fit",
        f"The best fit of each dataset: its RMSE in {' or '.join(units)}, and its |A| in rpm.",
        fits[list(TITLES)].dropna(axis="columns", how="all").rename(columns=TITLES),
        decimals={title: 2 for name, title in TITLES.items() if name.endswith("rpm")},
    )
