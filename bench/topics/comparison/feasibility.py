"""The share of trials that found a feasible point, for studies with constrained problems."""

from __future__ import annotations

from bench.analysis import feasibility
from bench.analysis.compare import table
from bench.report.parts import Section, Table
from bench.report.wording import count
from bench.topics.findings import Findings

TITLE = "Feasibility"


def sections(findings: Findings) -> tuple[Section, ...]:
    """Return the section with the feasibility rate of each cell on a constrained problem; none without such a one."""
    cells = feasibility(findings.trials.frame, findings.trials.traces, findings.trials.constrained)
    if cells.empty:
        return ()
    lost = int((cells["trials"] - cells["feasible"]).sum())
    text = (
        f"{count(len(findings.trials.constrained), 'problem')} with constraints, handled by "
        f"{findings.study.constraints!r}. Only feasible points are recorded. "
        + (
            f"{lost:,} of {count(int(cells['trials'].sum()), 'trial')} found no feasible point and score worse than "
            "any other."
            if lost
            else "Every trial found a feasible point."
        )
    )
    rates = table(cells, "rate")
    shown = Table(
        "feasibility",
        "Share of the trials of each cell whose best point is feasible, in %.",
        100 * rates.astype(float),
        lost=rates < 1,
        decimals=0,
        note="–: no trial; in red with ✗: a cell with trials that found no feasible point, or failed. The file also "
        "has the median evaluation of the first feasible point, infinite where at least half of the trials found none.",
        data=cells,
    )
    return (Section(TITLE, (text,), (shown,)),)
