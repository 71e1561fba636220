"""State what may explain an outcome besides the algorithms: options that differ, and budget that was left unused."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import NamedTuple

import pandas as pd

from bench.analysis.cells import budgets, scores
from bench.analysis.instances import SOLVED
from bench.analysis.unused_budget import unused_budget
from bench.topics.conditions import conditions
from bench.topics.findings import Findings

UNUSED = 0.01  # of the budget, on average, by which an optimizer may use less than another one


class Differing(NamedTuple):
    """What may explain an outcome besides the algorithms, each empty where nothing is known to.

    Attributes:
        clause: such as ``"handling is box for cma-es and repair for the 4 others"``.
        names: the conditions of the clause, which a study can set alike.
        left: the share of its budget that an optimizer left unused, by label, where that may explain a loss.
    """

    clause: str = ""
    names: tuple[str, ...] = ()
    left: Mapping[str, float] = MappingProxyType({})

    def __bool__(self) -> bool:
        """Whether anything may explain it."""
        return bool(self.clause or self.left)


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
    return Differing(
        conditions.differing(findings.study, findings.descriptions, leader),
        tuple(conditions.names_differing(findings.study, findings.descriptions, leader)),
        {str(label): 1 - float(share) for label, share in less.items()},
    )


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
