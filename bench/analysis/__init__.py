"""Statistics of a study: pure functions from the tidy frame (:func:`bench.load_results`) to tables; no plotting.

Example:
    >>> frame = bench.load_results("results/runs/thesis")
    >>> pairs = pairwise_tests(frame)
    >>> ranking(summarise(frame), pairs)
"""

from bench.analysis.anytime import best_so_far, evaluation_grid
from bench.analysis.cells import cells, coverage, in_study_order, labels, scores, summarise
from bench.analysis.compare import Matrix, comparison_matrix, ranking
from bench.analysis.pairwise import ALPHA, a12, pairwise_tests, tied_share
from bench.analysis.power import critical_distance, detectable_shift
from bench.analysis.timing import CONTENTION, HIDDEN_THREADS, timing

__all__ = [
    "ALPHA",
    "CONTENTION",
    "HIDDEN_THREADS",
    "Matrix",
    "a12",
    "best_so_far",
    "cells",
    "comparison_matrix",
    "coverage",
    "critical_distance",
    "detectable_shift",
    "evaluation_grid",
    "in_study_order",
    "labels",
    "pairwise_tests",
    "ranking",
    "scores",
    "summarise",
    "tied_share",
    "timing",
]
