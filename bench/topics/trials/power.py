"""How often the page would be wrong where optimizers do not differ, and the differences that its tests would find."""

from __future__ import annotations

from math import isnan, nan

import numpy as np

from bench import analysis
from bench.analysis.error_rates import MOST, ClaimRates, detectable_across, rates_of_equals, rates_of_spreads
from bench.analysis.strata import strata
from bench.report.wording import count, percent
from bench.topics.findings import Findings
from bench.topics.subject.against import parts_of


def blindness(findings: Findings) -> str:
    """Return a sentence on the differences that the tests would often miss."""
    n, tests, levels = findings.trials.per_cell[0], findings.final.tests, findings.final.levels
    trials = f"with {count(n, 'trial')} in the smallest cell"
    parts = []
    smallest = analysis.detectable_a12(n, levels.problems / tests) if levels.problems else nan
    if isnan(smallest):
        parts.append(
            f"{trials} nothing is found on single problems; from {findings.final.enough} trials a cell on "
            f"{'the test' if tests == 1 else f'the {tests:,} tests'} would find "
            "complete separation"
        )
    else:
        parts.append(f"{trials} the tests on problems would often miss an A12 below {smallest:.2f}")
    if levels.across:
        tested = findings.final.overall
        a12 = detectable_across(n, int(tested["problems"].iloc[0]), levels.across / findings.final.tested)
        if not isnan(a12):
            parts.append(f"the tests over all problems would often miss an A12 below {a12:.2f} on every problem")
    return "; ".join(parts) + " (power 80%)."


def error_text(findings: Findings) -> tuple[str, ...]:
    """Return how often this page would claim a difference where there is none, simulated for its design."""
    complete = [str(label) for label in findings.final.medians.index]
    by_problem = strata(findings.trials.frame)
    pools = [[np.concatenate(samples) for samples in by_problem[label]] for label in complete]
    optimizers, trials = len(findings.trials.optimizers), findings.trials.per_cell[0]
    if trials < 2:
        return ("With one trial a cell nothing is tested on single problems, and no rate is simulated.",)
    parts = None  # of the problems, in which a subject alone is tested
    if findings.final.subject:
        parts = [[complete.index(label) for label in part] for part in parts_of(findings, complete).values()]
    equal = rates_of_equals(pools, optimizers, findings.final.levels, parts=parts)
    spread = rates_of_spreads(trials, optimizers, len(pools), findings.final.levels, parts=parts)
    simulated = f"{MOST} of {optimizers}" if optimizers > MOST else str(optimizers)
    design = f"{simulated} optimizers, {count(len(complete), 'problem')}, {count(trials, 'trial')} a cell"
    design += f", {findings.final.subject} against each other one" if findings.final.subject else ""
    return (
        f"How often a page of this design ({design}) claims any difference where there is none; the rule allows 5%.",
        f"Identical optimizers, the trials of each problem dealt out to them at random: {_rate(equal)}.",
        f"Optimizers with A12 = 0.5 for every pair, the spread doubling from one to the next: {_rate(spread)}.",
        f"“Not separable” does not mean “equal”: {blindness(findings)}",
    )


def _rate(rates: ClaimRates) -> str:
    error = (rates.any * (1 - rates.any) / rates.studies) ** 0.5
    return (
        f"{percent(rates.any)} of {rates.studies:,} simulated studies (standard error {100 * error:.1f}%); an "
        f"optimizer separably lower on any problem in {percent(rates.problems)}, a difference over all problems in "
        f"{percent(rates.across)}"
    )
