"""Results of trials that no search has made."""

import numpy as np

from bench.contract.objective import Trace
from bench.trial.columns import MEASURED
from bench.trial.trial import Result

TRACE = Trace(np.ones(1, dtype=np.int64), np.ones(1))


def result(x, fun, *, trace=TRACE, seed=1, **known):
    """Return a result whose other columns are the least that they may be unless they are known."""
    least = {column.name: "" if column.kind is str else column.kind(max(column.limits.least, 0)) for column in MEASURED}
    return Result(**least | {"fun": fun} | known, x=np.array(x), trace=trace, metrics={}, seed=seed)
