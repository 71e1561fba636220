"""State what differs between the leader and its rivals besides their algorithms, as a clause."""

from __future__ import annotations

import pandas as pd

from bench.analysis.cells import budgets, scores
from bench.analysis.instances import SOLVED
from bench.analysis.stages import unused_budget
from bench.report.wording import listing, percent
from bench.topics.findings import Findings
from bench.topics.matched import conditions

UNUSED = 0.01  # of the budget, on average, by which a rival may use less than the leader


def differing(findings: Findings) -> str:
    """Return a clause on what may favour the leader besides its algorithm; "" where nothing is known to.

    That is :func:`options_differing`, and the share of the budget that a rival used, where the leader used more, such
    as ``"handling is box for cma-es and repair for the 4 others, gwo stopped after 72% of the budget"``.
    """
    leader, spent = findings.leader, _used(findings)
    less = spent["needed"][spent["needed"] < min(float(spent["used"][leader]), 1.0) - UNUSED].drop(
        leader, errors="ignore"
    )
    early = [f"{label} stopped after {percent(share)}" for label, share in less.sort_values().items()]
    stopped = f"{listing(early, at_most=conditions.MOST_LABELS)} of the budget" if early else ""
    return ", ".join(filter(None, (options_differing(findings), stopped)))


def options_differing(findings: Findings) -> str:
    """Return the options that may favour the leader, as a clause; "" if none is known to."""
    return conditions.differing(findings.study, findings.descriptions, findings.leader)


def _used(findings: Findings) -> pd.DataFrame:
    """Return by optimizer the share of the budget ``used``, and that ``needed``, of which the optimum needs all."""
    trials = findings.trials
    frame, budget = trials.measured, trials.common or trials.allowed
    optimum = frame["problem"].astype(object).map(trials.unbeaten).astype(float)
    solved = scores(frame) <= optimum + SOLVED
    spent = pd.to_numeric(frame["nfev"], errors="coerce").astype(float)
    kinds = {"used": spent, "needed": spent.mask(solved, budgets(frame, budget))}
    shares = {
        kind: 1 - unused_budget(frame.assign(nfev=nfev), budget).set_index("optimizer")["unused"].astype(float)
        for kind, nfev in kinds.items()
    }
    return pd.DataFrame(shares)
