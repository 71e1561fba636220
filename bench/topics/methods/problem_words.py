"""Describe the problems of a study in words: dimensions, boxes, optima, and the meaning of their values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nan

import pandas as pd

from bench.report.parts import Table
from bench.report.wording import MISSING, count, listing
from bench.results.results import ProblemFacts

Known = Mapping[str, ProblemFacts]  # by label

NAMED = 5  # problems that a sentence names
UNNAMED = "the problem itself"  # where an optimum is from whose problem does not say it


def dimensions(facts: Known) -> list[int]:
    """Return the dimensions of the problems, as far as they are known, from small to large."""
    return sorted({len(problem.box) for problem in facts.values()} - {0})


def box_text(box: Mapping[str, tuple[float, float]]) -> str:
    """Return bounds that all variables share as ``"[-5, 5]^d"``; "" where they differ or are not known."""
    ends = set(box.values())
    return "".join(f"[{low:g}, {high:g}]^d" for low, high in ends) if len(ends) == 1 else ""


def boxes(facts: Known) -> dict[str, str]:
    """Return the problems of each box, in words: ``{"[-5, 5]^d": "the bbob problems"}``; "" of those without one."""
    return _grouped(facts, lambda problem: box_text(problem.box) if problem.box else None)


def optima(facts: Known) -> dict[str, str]:
    """Return the problems whose optimum is known, in words, by where it is from."""
    return _grouped(facts, lambda problem: None if problem.optimum is None else problem.optimum_source or UNNAMED)


def measures(facts: Known) -> dict[str, str]:
    """Return the problems, in words, by the meaning that they state for their objective value."""
    return _grouped(facts, lambda problem: problem.measure or None)


def suites(facts: Known) -> str:
    """Return the problems in words such as ``"24 functions of bbob in dimensions 2, 5 and 10"``.

    "" where they are not all functions of suites, each in each dimension of its suite once.
    """
    members: dict[str, list[tuple[str, int]]] = {}
    for problem in facts.values():
        features, size = problem.features, len(problem.box)
        if not size or not {"suite", "function"} <= set(features):
            return ""
        members.setdefault(str(features["suite"]), []).append((str(features["function"]), size))
    parts = []
    for suite, cells in members.items():
        functions, sizes = {function for function, _ in cells}, sorted({size for _, size in cells})
        if len(functions) * len(sizes) != len(cells) or len(set(cells)) != len(cells):
            return ""
        noun = "dimensions" if len(sizes) > 1 else "dimension"
        parts.append(f"{count(len(functions), 'function')} of {suite} in {noun} {listing(list(map(str, sizes)))}")
    return listing(parts)


def problems_named(labels: Sequence[str], facts: Known) -> str:
    """Return some of the problems in words: all of them, whole families by name, or one by one."""
    if len(labels) == len(facts):
        return "the problem" if len(facts) == 1 else "all problems"
    families: dict[str, list[str]] = {}
    for label in facts:
        families.setdefault(_family(label, facts), []).append(label)
    whole = [name for name, members in families.items() if {*members} <= {*labels} and len(members) > 1]
    if {*labels} == {label for name in whole for label in families[name]}:
        return f"the {listing(whole, at_most=NAMED)} problems"
    return listing(labels, at_most=NAMED)


def problems_table(facts: Known, members: Mapping[str, Sequence[str]]) -> Table:
    """Return the table of the problems: dimension, instances, box, and optimum with its source; every bound as data.

    Args:
        facts: of the problems, by label.
        members: the instances that each problem stands for.
    """
    rows = {
        label: {
            "d": len(problem.box) or None,
            "instances": len(members[label]),
            "box": box_text(problem.box) or ("by variable" if problem.box else MISSING),
            "constraints": "yes" if problem.constraints else "no",
            "optimum": problem.optimum,
            "optimum from": (problem.optimum_source or UNNAMED) if problem.optimum is not None else MISSING,
        }
        for label, problem in facts.items()
    }
    shown = pd.DataFrame.from_dict(rows, orient="index").rename_axis("problem").astype({"d": "Int64"})
    if (shown["instances"] == 1).all():
        shown = shown.drop(columns="instances")
    bounds = [
        (label, name, low, high, problem.optimum)
        for label, problem in facts.items()
        for name, (low, high) in (problem.box or {"": (nan, nan)}).items()
    ]
    return Table(
        "problems",
        f"The {count(len(facts), 'problem')}: dimension d, bounds and optimum.",
        shown,
        note="The CSV file has the bounds of every variable. The optimum of pooled instances is that of precisions.",
        data=pd.DataFrame(bounds, columns=["problem", "variable", "lower", "upper", "optimum"]),
    )


def _family(label: str, facts: Known) -> str:
    return str(facts[label].features.get("suite") or label.rpartition("-")[0] or label)


def _grouped(facts: Known, key: Callable[[ProblemFacts], str | None]) -> dict[str, str]:
    """Return the problems of each key in words, the most frequent key first, without those of None."""
    groups: dict[str, list[str]] = {}
    for label, problem in facts.items():
        if (name := key(problem)) is not None:
            groups.setdefault(name, []).append(label)
    ordered = sorted(groups.items(), key=lambda group: -len(group[1]))
    return {name: problems_named(labels, facts) for name, labels in ordered}
