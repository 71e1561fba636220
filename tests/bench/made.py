"""Results of trials that no search has made, and of problems that no plug-in knows."""

import numpy as np

from bench import Results
from bench.contract.objective import Trace
from bench.execution.plan import Listener
from bench.trial.columns import MEASURED
from bench.trial.trial import Result

TRACE = Trace(np.ones(1, dtype=np.int64), np.ones(1))


class Heard(Listener):
    """A listener that calls a function with every finished trial and its row."""

    def __init__(self, trial):
        self.trial = trial


class Known(Results):
    """Results of a folder whose problems have the facts that a function returns for a label."""

    def __init__(self, path, facts_of):
        self._facts_of = facts_of
        super().__init__(path)

    def facts(self, label):
        return self._facts_of(label)


def result(x, fun, *, trace=TRACE, seed=1, **known):
    """Return a result whose other columns are the least that they may be unless they are known."""
    least = {column.name: "" if column.kind is str else column.kind(max(column.limits.least, 0)) for column in MEASURED}
    return Result(**least | {"fun": fun} | known, x=np.array(x), trace=trace, metrics={}, seed=seed)
