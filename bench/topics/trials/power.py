"""How often the page would be wrong where optimizers do not differ, and the differences that its tests would find."""

from __future__ import annotations

from math import isnan, nan

import numpy as np
import pandas as pd

from bench import analysis
from bench.analysis import ALPHA
from bench.analysis.error_rates import MOST, ClaimRates, detectable_across, rates_of_equals, rates_of_spreads
from bench.analysis.strata import strata
from bench.report.parts import Section, Table
from bench.report.wording import count, percent
from bench.topics.findings import Findings
from bench.topics.subject.against import parts_of
from bench.topics.topic import Topic

TITLE = "Power"


def section(findings: Findings) -> Section:
    """Return the differences that the tests can and cannot find with this study's trials."""
    if findings.trials.frame.empty or len(findings.trials.optimizers) < 2 or not len(findings.final.medians):
        return Section(TITLE, ("There is nothing to compare, so no test has any power.",))
    tests, pairs, level = findings.final.tests, findings.final.tested, findings.final.level_on_problems
    rows = []
    for n in sorted(set(findings.trials.per_cell)):
        for name, level_of_test in (("a single test", ALPHA), ("the first of all tests", level / tests)):
            smallest = analysis.detectable_a12(n, level_of_test)
            rows.append((n, name, level_of_test, smallest, analysis.trials_to_separate(1, level_of_test)))
    names = ["trials", "adjusted as", "level", "A12 found", "separation from"]
    table = pd.DataFrame(rows, columns=names)
    shown = Table(
        "power",
        "The smallest A12 that a test on a problem finds with a power of 80%, and the trials from which on complete "
        "separation is significant.",
        table.astype({"level": str}).assign(level=[f"{level:.2g}" for level in table["level"]]),
        decimals={"A12 found": 2},
        note="For two normal samples of one spread. –: nothing can be significant. Tests: "
        f"{tests:,} on problems, {pairs:,} across them.",
        data=table,
    )
    text = blindness(findings)
    return Section(TITLE, (f"{text[0].upper()}{text[1:]}",), (shown,), on_demand=True)  # the verdict has the sentence


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


TOPIC = Topic(TITLE, section, place=710)
