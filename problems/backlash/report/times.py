"""Fig. 7.5: the mean time of one experiment."""

import pandas as pd

from bench.analysis import timing
from bench.report import Section, Table
from bench.report.wording import listing, seconds


def sections(frame: pd.DataFrame) -> list[Section]:
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
    return [
        Section("Execution time (thesis Fig. 7.5)", (text,), (Table("mean-times", caption, shown, decimals=decimals),))
    ]
