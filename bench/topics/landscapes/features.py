"""Features of the landscapes of a study's problems, from small samples, as far as the problems load here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from bench.analysis.landscape import describe
from bench.errors import BenchError
from bench.topics.findings import Findings

POINTS = 50  # a dimension: enough for these features (Kerschke, Preuss, Wessing and Trautmann 2016, GECCO)
LEAST, MOST = 100, 1_000  # points
PATIENCE = 2.0  # seconds that the evaluations of a sample may take, by the times of the trials


@dataclass(frozen=True)
class Landscapes:
    """The features of the problems that could be described.

    Attributes:
        table: features by problem.
        left_out: why a problem is not described, by label.
    """

    table: pd.DataFrame
    left_out: Mapping[str, str]


def landscapes(findings: Findings) -> Landscapes:
    """Return the features of the problems; of one with instances, those of the first.

    A problem that does not load, or would take seconds, is left out: a report must not wait for its objective.
    """
    results, members = findings.results, findings.trials.pooled.members
    rows, left_out = {}, {}
    finished = results.frame[results.frame["status"] == "ok"].groupby("problem")[["objective_s", "nfev"]].sum()
    pace = (finished["objective_s"].astype(float) / finished["nfev"].astype(float)).to_dict()
    for label in findings.trials.problems:
        instance = members[label][0]
        points = sample(results.dimension(instance))
        try:
            taken = pace.get(instance, 0.0) * results.study.parallel * points  # unknown of imported trials
            if not taken <= PATIENCE:
                raise BenchError("its evaluations take too long, or their time is unknown")
            rows[label] = describe(results.problem(instance), points)
        except Exception as error:  # a plug-in may raise anything
            left_out[label] = str(error)
    return Landscapes(pd.DataFrame.from_dict(rows, orient="index").rename_axis("problem"), left_out)


def sample(dimension: int) -> int:
    """Return the points by which a problem of this dimension is described, which are evaluations of a budget."""
    return min(max(POINTS * dimension, LEAST), MOST)
