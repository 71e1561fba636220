"""State what may explain an outcome besides the algorithms: options that differ, and budget that was left unused."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import pandas as pd

from bench.analysis.cells import budgets, scores
from bench.analysis.instances import SOLVED
from bench.analysis.stages import unused_budget
from bench.report.prose import speaker
from bench.report.wording import listing, percent
from bench.topics.conditions import conditions
from bench.topics.findings import Findings

UNUSED = 0.01  # of the budget, on average, by which an optimizer may use less than another one
SAY = speaker(__package__, MOST_LABELS=conditions.MOST_LABELS)


class Differing(NamedTuple):
    """What may explain an outcome besides the algorithms, each "" where nothing is known to.

    Attributes:
        clause: such as ``"handling is box for cma-es and repair for the 4 others, gwo left 28% of its budget unused"``.
        line: the same in at most twenty words, with what removes it.
        remedy: sentences on what removes it.
    """

    clause: str = ""
    line: str = ""
    remedy: str = ""


def differing(findings: Findings, beaten: Collection[str], lost: Collection[str] = ()) -> Differing:
    """Return what may explain that the leader beats some rivals, and loses to others.

    Options may explain either. Less budget explains a loss alone: that of a rival which used less than the leader, or
    that of the leader to a rival which used more. Nobody loses by what it left after it had found the optimum.
    """
    if not beaten and not lost:
        return Differing()
    leader, spent = findings.leader, findings.of(shares_used)
    rivals = spent["needed"].reindex([label for label in spent.index if label in beaten])
    less = rivals[rivals < min(float(spent["used"][leader]), 1.0) - UNUSED]
    most = spent["used"].reindex([*lost]).clip(upper=1.0).max()
    own = spent["needed"][[leader]]
    less = pd.concat([less, own[own < most - UNUSED]]).sort_values()
    left = listing([f"{label} left {percent(1 - share)}" for label, share in less.items()], conditions.MOST_LABELS)
    options = options_differing(findings)
    clauses = (options, f"{left} of its budget unused" if len(less) else "")
    names = conditions.names_differing(findings.study, findings.descriptions, leader)
    remedy = (SAY("alike_in_the_study", names), SAY("restarts", list(less.index)))
    return Differing(
        ", ".join(filter(None, clauses)), SAY("unlike", names, list(less.index)), " ".join(filter(None, remedy))
    )


def options_differing(findings: Findings) -> str:
    """Return the options that may favour or harm the leader, as a clause; "" if none is known to."""
    return conditions.differing(findings.study, findings.descriptions, findings.leader)


def shares_used(findings: Findings) -> pd.DataFrame:
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
