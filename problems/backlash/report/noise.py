"""Table 7.3: the amplitude found on noisy recordings, beside the published one and that of the best fit."""

from __future__ import annotations

import re

import pandas as pd

from bench import Study
from bench.report import Section, Table
from bench.topics import StoredResults
from problems.backlash.published.recordings import table_7_3
from problems.backlash.recordings import Recording
from problems.backlash.report.accuracy import SAY, estimates
from problems.backlash.report.fitting_errors import PUBLISHED_BUDGET, PUBLISHED_TRIALS
from problems.backlash.sensor.estimate import Settings, infer_backlash
from problems.backlash.sensor.load_turn import fold
from problems.backlash.signature.datasets import NOISES, peak_to_peak
from problems.backlash.signature.problem import SignatureFit

TITLE = "Noise sensitivity (thesis Table 7.3)"
HEALTHY = 0.02  # rps; the largest |A| accepted without backlash, about twice that of the thesis (0.0099)
COLUMNS = {"theoretical": "A", "noise": "noise", "mean": "mean |A|", "stdev": "stdev", "error": "error %"}


def sections(results: StoredResults, frame: pd.DataFrame, truths: pd.DataFrame) -> list[Section]:
    """Return the section on Table 7.3, none for a study without noisy problems or without any amplitude of them."""
    noisy = noisy_problems(results.study)
    data = estimates(frame, truths, "amplitude_rpm")
    cells = by_cell(data[data["problem"].isin(set(noisy["problem"]))], noisy)
    if cells.empty:
        return []
    best = best_fits(results, cells)
    levels = levels_of(cells)
    text = [conditions(results.study), *(sentence for level in levels for sentence in sentences(cells, best, level))]
    tables = [side_by_side(cells[cells["noise level"] == level], level) for level in levels]
    return [Section(TITLE, tuple(text), (*tables, *([beside_best(best)] if len(best) else [])))]


def conditions(study: Study) -> str:
    """Return a sentence that compares the study's conditions with the published ones."""
    asked = f"{PUBLISHED_TRIALS} trials of {PUBLISHED_BUDGET:,} evaluations"
    same = (study.trials, study.budget.number) == (PUBLISHED_TRIALS, PUBLISHED_BUDGET)
    return SAY("conditions", study, same, asked)


def noisy_problems(study: Study) -> pd.DataFrame:
    """Return every noisy problem of a study: problem (its label), dataset (0 without backlash), noise level, noise.

    The noise level is "low" or "high", with the range of t0 where that is not the whole recording: "low, t0 within 1
    T_f". The noise is its amplitude in rps, half of its peak-to-peak value.
    """
    rows = []
    for entry in study.problems:
        if match := re.fullmatch(r"noisy-(\d\d)", entry.name):
            noise, turns = entry.options.get("noise", NOISES[0]), entry.options.get("t0_turns")
            level = noise if turns is None else f"{noise}, t0 within {turns:g} T_f"
            rows.append((entry.label, int(match[1]), level, peak_to_peak(int(match[1]), noise) / 2))
    return pd.DataFrame(rows, columns=["problem", "dataset", "noise level", "noise"])


def levels_of(cells: pd.DataFrame) -> list[str]:
    """Return the noise levels of some cells in their order, "low" before "high"."""
    return sorted(cells["noise level"].unique(), key=lambda level: NOISES.index(level.partition(",")[0]))


def words(level: str) -> str:
    """Return a noise level in words, such as "low noise, t0 within 1 T_f"."""
    noise, comma, rest = level.partition(",")
    return f"{noise} noise{comma}{rest}"


def by_cell(data: pd.DataFrame, noisy: pd.DataFrame) -> pd.DataFrame:
    """Return a row a problem and optimizer in the columns of Table 7.3, in rps and percent.

    ``data`` has the amplitudes (:func:`problems.backlash.report.accuracy.estimates`) of the ``noisy`` problems.

    Columns: problem, optimizer, trials, dataset, noise level, theoretical, noise (amplitude), mean and stdev of |A|,
    error (of the mean, as published) and run error (the mean of every run's own); errors are missing without backlash.
    """
    rps = data.assign(found=data["found"] / 60, expected=data["expected"] / 60)
    rps = rps.assign(miss=(rps["found"] - rps["expected"]).abs())
    cells = rps.groupby(["problem", "optimizer"], observed=True).agg(
        trials=("found", "count"), theoretical=("expected", "first"), mean=("found", "mean"), stdev=("found", "std"),
        miss=("miss", "mean"),
    )  # fmt: skip
    cells = cells[cells["trials"] > 0].reset_index().astype({"problem": object, "optimizer": object})
    cells = cells.merge(noisy, on="problem")
    cells["error"] = relative(cells["mean"] - cells["theoretical"], cells["theoretical"])
    cells["run error"] = relative(cells.pop("miss"), cells["theoretical"])
    return cells


def relative(error: pd.Series[float], theoretical: pd.Series[float]) -> pd.Series[float]:
    """Return the size of an error in percent of the theoretical value, missing where that is 0."""
    return 100 * error.abs() / theoretical.where(theoretical > 0)


def best_fits(results: StoredResults, cells: pd.DataFrame) -> pd.DataFrame:
    """Return the amplitudes inferred from the best fit, a row a problem.

    Columns: problem, dataset, noise level, theoretical, mean (the fit's |A|), error, estimate (the virtual sensor's
    amplitude from it, 0 where it detects no disturbance) and estimate error.
    """
    rows = cells.drop_duplicates("problem")[["problem", "dataset", "noise level", "theoretical"]]
    rows = rows[[not results.facts(label).reason for label in rows["problem"]]]
    rows[["mean", "estimate"]] = [_amplitudes_of_best(results, label) for label in rows["problem"]]
    for amplitude, error in (("mean", "error"), ("estimate", "estimate error")):
        rows[error] = relative(rows[amplitude] - rows["theoretical"], rows["theoretical"])
    return rows.dropna(subset="mean")


def _amplitudes_of_best(results: StoredResults, label: str) -> tuple[float, float]:
    """Return |A| in rps of the best fit inside the box, which CMA-ES searched for, and the sensor's amplitude."""
    problem = results.problem(label).unscored
    if not isinstance(problem, SignatureFit):
        return float("nan"), float("nan")
    size = problem.describe(problem.reference().x)["amplitude_rpm"] / 60
    if problem.unit != "rps":  # the sensor's own unit, and the noise study's
        return size, float("nan")
    folded = fold(Recording(float(problem.time[0]), problem.dt, problem.signal), problem.period)
    return size, infer_backlash(problem, Settings(resamples=0), folded).amplitude_rps


def sentences(cells: pd.DataFrame, best: pd.DataFrame, level: str) -> list[str]:
    """Return sentences that compare each optimizer's and the best fit's errors at a noise level with the published."""
    text, begin = [], words(level)[0].upper() + words(level)[1:]
    for label, rows in cells[cells["noise level"] == level].groupby("optimizer", sort=False):
        text += _compared(f"{begin}, {label}", "mean |A|", rows)
        text += _without_backlash(f"{label} finds a mean |A|", rows)
    fits = best[best["noise level"] == level]
    text += _compared(f"{begin}, the best fit", "|A|", fits)
    text += _without_backlash("the best fit has an |A|", fits)
    sensor = fits.assign(mean=fits["estimate"], error=fits["estimate error"])
    text += _compared(f"{begin}, the virtual sensor (best fit and calibration)", "A", sensor)
    return text + _without_backlash("the virtual sensor estimates an amplitude", sensor)


def _compared(who: str, what: str, rows: pd.DataFrame) -> list[str]:
    """Return a sentence on how many errors are below the published ones; none without a published row."""
    both = rows.merge(table_7_3()["error"], on="dataset", suffixes=("", " published"))
    both = both.dropna(subset=["error", "error published"])
    if both.empty:
        return []
    worse = both.loc[both["error"] >= both["error published"], "problem"].tolist()
    return [SAY("compared", who, what, both, worse, rows["run error"].mean() if "run error" in rows else None)]


def _without_backlash(who: str, rows: pd.DataFrame) -> list[str]:
    sizes = rows.loc[rows["dataset"] == 0, "mean"]
    return [SAY("without_backlash", who, value, table_7_3()["mean"][0], HEALTHY) for value in sizes]


def side_by_side(cells: pd.DataFrame, level: str) -> Table:
    """Return Table 7.3 at a noise level, each column beside the published one."""
    printed = table_7_3().reindex(cells["dataset"]).set_index(cells.index)
    columns: dict[str, pd.Series[float]] = {}
    for name, title in COLUMNS.items():
        columns |= {f"{title} published": printed[name], title: cells[name]}
    columns["single runs %"] = cells["run error"]
    remark = (
        "" if level.startswith("low") else " The published columns are those of the low level, the only one printed."
    )
    return Table(
        f"table-7-3-{level.replace(',', '').replace(' ', '-')}",
        f"Amplitude found with {words(level)}, in rps (thesis Table 7.3).",
        pd.DataFrame(columns).set_index([cells["problem"], cells["optimizer"]]),
        decimals={column: 2 if "%" in column else 4 for column in columns},
        note="A: the positive peak of the undecimated disturbance; noise: half of its peak-to-peak value. Ours are "
        "values of |A|. The error is that of the mean, |mean − A| / A, as the published one is: the printed digits of "
        "all ten rows give it within 0.01 percentage points. A cannot have had both signs in any row, as the standard "
        f"deviation is small compared with the mean. Single runs: the mean of every run’s own error.{remark}",
    )


def beside_best(best: pd.DataFrame) -> Table:
    """Return the table of the best fits, each beside the published error."""
    printed = table_7_3()["error"].reindex(best["dataset"]).set_axis(best.index)
    columns = {
        "A": best["theoretical"], "|A| of best fit": best["mean"], "error %": best["error"],
        "A by sensor": best["estimate"], "its error %": best["estimate error"], "error % published": printed,
    }  # fmt: skip
    return Table(
        "table-7-3-best-fit",
        "Amplitude in rps of the best fit inside the box, found without an optimizer, and its relative error.",
        pd.DataFrame(columns).set_index(best["problem"]),
        decimals={column: 2 if "%" in column else 4 for column in columns},
        note="These errors come from the objective, the sampling and the noise, not from an optimizer. The published "
        "errors are at the low level of noise.",
    )
