"""State what differs between the optimizers of a study besides their algorithms, as a clause."""

from __future__ import annotations

from bench.optimizer import CONDITIONS
from bench.report.conditions import MOST_LABELS, by_value, conditions, grouped
from bench.report.findings import Findings
from bench.report.wording import listing

UNUSED = 0.01  # of the budget, on average, that an optimizer may leave as others do


def differing(findings: Findings) -> str:
    """Return what differs between the optimizers besides their algorithms as a clause; "" where nothing is known to.

    That is :func:`options_differing`, and the share of the budget that an optimizer used. Such as ``"handling and start
    are box, midpoint for cma-es and repair, random for the 4 others, cma-es stopped after 72% of the budget"``. An
    optimizer without an option, such as a search without a population, does not differ in it.
    """
    spent = 1 - findings.anytime.unused.set_index("optimizer")["unused"].astype(float)
    early = [f"{label} stopped after {share:.0%}" for label, share in spent[spent < 1 - UNUSED].sort_values().items()]
    stopped = f"{listing(early, at_most=MOST_LABELS)} of the budget" if early else ""
    return ", ".join(filter(None, (options_differing(findings), stopped)))


def options_differing(findings: Findings) -> str:
    """Return which conditions differ by the options of the optimizers as a clause; "" where none is known to."""
    table = conditions(findings.study, findings.descriptions)
    alike: dict[tuple[tuple[str, ...], ...], dict[str, list[str]]] = {}  # conditions and values, by who has the same
    set_here = {name for entry in findings.study.optimizers for name in entry.options}
    for name in CONDITIONS:
        groups = by_value(table[name].dropna())
        # The population that an algorithm takes of its own accord is a part of it.
        if len(groups) > 1 and (name != "agents" or name in set_here):
            alike.setdefault(tuple(map(tuple, groups.values())), {})[name] = [*groups]
    clauses = []
    for owners, values in alike.items():
        together = {", ".join(of_one): [*labels] for *of_one, labels in zip(*values.values(), owners, strict=True)}
        clauses.append(f"{listing([*values])} {'is' if len(values) == 1 else 'are'} {grouped(together)}")
    return ", ".join(clauses)
