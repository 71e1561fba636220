"""The thesis's own views of a study, Figs. 7.3 to 7.5, Tables 7.2 and 7.3, and the best fit there is, beside them."""

import pandas as pd

from bench import Results
from bench.analysis import in_study_order, timing
from bench.report import Section, Table
from bench.report.wording import listing, seconds
from problems.backlash.report import amplitudes, fitting_errors, levels, noise, reference
from problems.backlash.report.accuracy import expected_values


def sections(results: Results) -> list[Section]:
    """Return the sections on backlash, none for a study whose problems give no amplitude."""
    if "amplitude_rpm" not in results.frame:
        return []
    frame = in_study_order(results.frame, results.study)
    truths, unknown = expected_values(results)
    return [
        *levels.sections(frame, truths, unknown),
        *fitting_errors.sections(frame, results.study),
        *reference.sections(results, frame),
        *amplitudes.sections(frame, truths, results.study),
        *noise.sections(results, frame, truths),
        *_times(frame),
    ]


def _times(frame: pd.DataFrame) -> list[Section]:
    """Return the section on Fig. 7.5, none without a finished trial; the thesis prints no number to compare with."""
    table = timing(frame)
    table = table[table["trials"] > 0].sort_values("wall_mean", kind="stable").set_index("optimizer")
    if table.empty:
        return []
    mean = table["wall_mean"]
    times = listing([f"{seconds(value)} with {label}" for label, value in mean.items()])
    text = (
        f"One trial takes {times} on average. The thesis shows its times as bars without numbers, so none can be "
        "compared. The section on time has the bars, the medians and the quartiles."
    )
    shown = pd.DataFrame(
        {
            "trials": table["trials"],
            "mean time in s": mean,
            "times the fastest": mean / mean.iloc[0],
            "in the objective %": 100 * table["objective_mean"] / mean,
        }
    )
    caption = "Mean wall time of one trial, and the percentage of it spent in the objective."
    decimals = {"times the fastest": 1, "in the objective %": 1}
    means = Table("mean-times", caption, shown, decimals=decimals)
    return [Section("Execution time (thesis Fig. 7.5)", (text,), (means,))]
