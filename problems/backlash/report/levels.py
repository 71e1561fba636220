"""The backlash that the trials found, beside that of the datasets (thesis Fig. 7.3)."""

import numpy as np
import pandas as pd

from bench.report import Section, Table, count, listing
from problems.backlash.report import accuracy
from problems.backlash.signature.problem import TOLERANCE_RAD, TOLERANCE_RPM

TITLE = "Backlash found (datasets of thesis Fig. 7.3)"
METRICS = ("backlash_rad", "amplitude_rpm")


def sections(frame: pd.DataFrame, truths: pd.DataFrame, unknown: dict[str, str]) -> list[Section]:
    """Return the section on the backlash found, with a warning on the problems whose truth is not known."""
    # a missing plug-in gives the same reason for all its problems
    reasons = {reason: [label for label, why in unknown.items() if why == reason] for reason in unknown.values()}
    warnings = tuple(
        f"The expected values of {listing(problems)} are not known here and left out: {reason}."
        for reason, problems in reasons.items()
    )
    nothing = [Section(TITLE, warnings=warnings)] if warnings else []
    if METRICS[0] not in frame:  # of single oscillations
        return nothing
    backlash = accuracy.with_truth(accuracy.estimates(frame, truths, METRICS[0]))
    if backlash.empty:
        return nothing
    text = smallest_step(truths)
    text += (f"{accuracy.shares_within(backlash)} are within ±{TOLERANCE_RAD:g} rad of the true backlash.",)
    text += tuple(filter(None, [accuracy.signed_and_size(backlash, "e-6 rad", 1e6)]))
    if lost := int(backlash["found"].isna().sum()):
        why = "they failed, or the amplitude is outside the calibrated range"
        text += (f"{count(lost, 'trial')} of {len(backlash):,} gave no backlash: {why}.",)
    return [Section(TITLE, text, (_table(backlash),), warnings)]


def smallest_step(truths: pd.DataFrame) -> tuple[str, ...]:
    """Return a sentence on the smallest step of the amplitude between neighbouring datasets, none without neighbours.

    It is the accuracy asked of A, as the step in backlash is the accuracy asked of delta (section 7.2.3).
    """
    table = truths.pivot(index="problem", columns="figure", values="expected")
    if not set(METRICS) <= set(table):
        return ()
    steps = table.dropna().sort_values("backlash_rad").diff()
    neighbours = steps.loc[np.isclose(steps["backlash_rad"], 2 * TOLERANCE_RAD), "amplitude_rpm"]
    if neighbours.empty:
        return ()
    text = (
        f"Between datasets {2 * TOLERANCE_RAD:g} rad apart the expected amplitude grows by at least "
        f"{neighbours.min():.4f} rpm ({neighbours.max():.4f} rpm at most). On the thesis’s own datasets the smallest "
        f"step is {2 * TOLERANCE_RPM:.4f} rpm, and half of it is the accuracy asked of A."
    )
    return (text,)


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
