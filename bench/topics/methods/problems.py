"""The table of a study's problems: dimensions, boxes and optima."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan

import pandas as pd

from bench.report.parts import Table
from bench.report.wording import MISSING, count
from bench.results.results import ProblemFacts

UNNAMED = "the problem itself"  # where an optimum is from whose problem does not say it


def box_text(box: Mapping[str, tuple[float, float]]) -> str:
    """Return bounds that all variables share as ``"[-5, 5]^d"``; "" where they differ or are not known."""
    ends = set(box.values())
    return "".join(f"[{low:g}, {high:g}]^d" for low, high in ends) if len(ends) == 1 else ""


def problems_table(facts: Mapping[str, ProblemFacts], members: Mapping[str, Sequence[str]]) -> Table:
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
