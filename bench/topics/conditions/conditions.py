"""Find differences between the optimizers of a study besides their algorithms, as far as their options show them."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from bench.contract.optimizer import CONDITIONS
from bench.helpers.text import option
from bench.report.parts import Table
from bench.report.wording import MISSING, listing
from bench.study import Study
from bench.study.descriptions import Description
from bench.study.sweep import swept

UNKNOWN, NONE = "not known", "null"
MOST_VALUES, MOST_LABELS = 4, 5  # that a sentence names


def conditions(study: Study, descriptions: Mapping[str, Description]) -> pd.DataFrame:
    """Return each optimizer's conditions and the options that differ from its defaults, a row an optimizer.

    Columns: :data:`bench.contract.optimizer.CONDITIONS`, missing where the optimizer has no such option, and
    ``UNKNOWN`` where its description is not known and the study does not give it; and ``changed``, a dict of
    (value, default) by option, or None where the description is not known.
    """
    rows = []
    for entry in study.optimizers:
        description = descriptions.get(entry.label, Description())
        asked = {name: option(value) for name, value in entry.options.items()}
        values = asked if description.values is None else description.values
        row: dict[str, object] = {
            name: values.get(name, UNKNOWN if description.values is None else None) for name in CONDITIONS
        }
        usual = description.defaults or {}
        row["changed"] = (
            None
            if description.values is None
            else {name: (value, usual.get(name)) for name, value in values.items() if value != usual.get(name)}
        )
        rows.append(row)
    return pd.DataFrame(rows, [entry.label for entry in study.optimizers], [*CONDITIONS, "changed"], dtype=object)


def differing(study: Study, descriptions: Mapping[str, Description], leader: str) -> str:
    """Return the conditions that may favour the leader over a rival, as a clause; "" if none is known to.

    Such as ``"handling and start are box, midpoint for cma-es and repair, random for the 4 others"``. None is one that
    an algorithm takes of its own accord (the population, where the study sets none), that the leader has no option for,
    or that a sweep varies: there it is the question.
    """
    clauses = []
    for names, joint in _differing(study, descriptions, leader).items():
        clauses.append(f"{listing(names)} {'is' if len(names) == 1 else 'are'} {grouped(joint)}")
    return ", ".join(clauses)


def _differing(
    study: Study, descriptions: Mapping[str, Description], leader: str
) -> dict[tuple[str, ...], dict[str, list[str]]]:
    """Return the labels by their values, of each set of conditions that the same optimizers share."""
    table = conditions(study, descriptions)
    set_here = {name for entry in study.optimizers for name in entry.options}
    sweeps = {entry.label: swept(entry.label, entry.options) for entry in study.optimizers}
    others = [label for label, sweep in sweeps.items() if label != leader and sweep == sweeps[leader]]
    together: dict[tuple[tuple[str, ...], ...], dict[str, list[str]]] = {}  # conditions and values, by who has the same
    for name in CONDITIONS:
        if table.at[leader, name] is None or (name == "agents" and name not in set_here):
            continue
        varied = others if name in sweeps[leader][1] else []
        groups = by_value(table[name].dropna().drop(varied))
        if len(groups) > 1:
            together.setdefault(tuple(map(tuple, groups.values())), {})[name] = [*groups]
    return {
        tuple(values): {", ".join(of_one): [*labels] for *of_one, labels in zip(*values.values(), owners, strict=True)}
        for owners, values in together.items()
    }


def names_differing(study: Study, descriptions: Mapping[str, Description], leader: str) -> list[str]:
    """Return the names of the conditions that :func:`differing` states."""
    return [name for names in _differing(study, descriptions, leader) for name in names]


def by_value(values: pd.Series[str]) -> dict[str, list[str]]:
    """Return the labels of the optimizers by what is said of their value, without those whose value is not known."""
    groups: dict[str, list[str]] = {}
    for label, value in values[values != UNKNOWN].items():
        groups.setdefault(_said(value), []).append(str(label))
    return groups


def _said(value: object) -> str:
    """Return the value of a condition in words."""
    return "no option" if value is None else "automatic" if value == NONE else str(value)


def grouped(groups: Mapping[str, list[str]]) -> str:
    """Return names by value, the largest group last, such as ``"box for cma-es and repair for the 4 others"``."""
    ordered = sorted(groups.items(), key=lambda group: len(group[1]))
    if len(ordered) > MOST_VALUES:
        return f"set in {len(ordered)} ways"
    parts = [f"{value} for {listing(labels, at_most=MOST_LABELS)}" for value, labels in ordered[:-1]]
    value, labels = ordered[-1]
    most = f"the {len(labels)} others" if len(labels) > 1 else labels[0]
    return listing([*parts, f"{value} for {most}"])


def conditions_table(study: Study, descriptions: Mapping[str, Description]) -> Table:
    """Return the table of the conditions and changed options of every optimizer."""
    table = conditions(study, descriptions)
    shown = table[list(CONDITIONS)].map(lambda value: MISSING if value is None else _said(value))
    shown = shown.assign(**{"options other than the defaults": table["changed"].map(_spelled)})
    return Table(
        "conditions",
        "What differs between the optimizers besides their algorithms, as their options show it.",
        shown.rename_axis("optimizer"),
        note=f"agents: the population size; in brackets: the default; {MISSING}: the optimizer has no such option; "
        "automatic: the optimizer chooses it.",
    )


def _spelled(changed: dict[str, tuple[str, str | None]] | None) -> str:
    if changed is None:
        return UNKNOWN
    pairs = [
        f"{name} = {value}" + ("" if usual is None else f" ({_said(usual)})")
        for name, (value, usual) in changed.items()
    ]
    return ", ".join(pairs) or "none"
