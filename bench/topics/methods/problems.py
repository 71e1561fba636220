"""The table of a study's problems: boxes and optima."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan

import pandas as pd

from bench.results.results import Bounds, ProblemFacts

UNNAMED = "the problem itself"  # where an optimum is from whose problem does not say it


def bounds(facts: Mapping[str, ProblemFacts]) -> pd.DataFrame:
    """Return a row a variable of each problem: problem, variable, lower, upper, constraints, optimum, optimum_from."""
    rows = [
        (label, name, low, high, problem.constraints, problem.optimum, _source(problem))
        for label, problem in facts.items()
        for name, (low, high, _) in (problem.box or {"": Bounds(nan, nan)}).items()
    ]
    return pd.DataFrame(
        rows, columns=["problem", "variable", "lower", "upper", "constraints", "optimum", "optimum_from"]
    )


def _source(problem: ProblemFacts) -> str | None:
    return None if problem.optimum is None else problem.optimum_source or UNNAMED
