"""The shares of runs that a person remembers of a study on backlash, for the first screen of its report."""

from __future__ import annotations

import pandas as pd

from bench.analysis import in_study_order
from bench.topics import StoredResults
from problems.backlash.report.accuracy import estimates, expected_values, shares_within
from problems.backlash.report.reference import compared, signature_problems

WITHIN = {"amplitude_rpm": "amplitude within the band", "backlash_rad": "gap within the band"}


def shares(results: StoredResults) -> pd.DataFrame:
    """Return by optimizer the share of its runs, 0 to 1, that found the best fit, the amplitude and the half-gap.

    Columns: ``best fit`` and those of ``WITHIN``, each where it is known of a problem of the study. The bands are half
    of the accuracy asked for in section 7.2.1; a run that failed found nothing.
    """
    frame, columns = in_study_order(results.frame, results.study), {}
    if problems := signature_problems(results, frame):
        trials, *_ = compared(results, frame, problems)
        columns["best fit"] = trials.groupby("optimizer", observed=True)["found"].mean()
    truths, _ = expected_values(results)
    for figure, name in WITHIN.items():
        if figure in frame and figure in truths["figure"].to_numpy():
            columns[name] = shares_within(estimates(frame, truths, figure))
    return pd.DataFrame(columns)
