"""Surveyed implementations as runs would give them, from random numbers."""

import numpy as np

from bench.analysis.similarity import STAGES, TRAITS
from bench.atlas.runs import MEASURES, PROBLEMS, Surveyed
from bench.atlas.table import Implementation


def surveyed(label, *, method="m", trials=12, shift=0.0, seed=0, decimals=2, **found):
    """Return an implementation whose trials are rounded normal numbers, so that they tie, moved by ``shift``."""
    rng = np.random.default_rng(seed)
    own = Implementation(method, label, label)
    measures = {
        problem: 10.0 ** (rng.standard_normal((trials, len(MEASURES))).round(decimals) + shift) for problem in PROBLEMS
    }
    behaviours = {problem: rng.standard_normal((trials, STAGES * len(TRAITS))) + shift for problem in PROBLEMS}
    facts = {"clamped": 0.0, "evaluations": 60.0, "microseconds": 1.0} | found
    return Surveyed(own, "library 1.0", measures, behaviours, **facts)
