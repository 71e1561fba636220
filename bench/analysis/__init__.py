"""Statistics of a study: pure functions from the tidy frame (:func:`bench.load_results`) to tables; no plotting.

Problem by problem, at the end of the budget: :func:`summarise`, :func:`chances`, :func:`pairwise_tests`,
:func:`comparison_matrix`, :func:`regret`. Over these problems: :func:`order`,
:func:`compare`, :func:`wins_all`, :func:`medians`. How many trials are enough: :func:`detectable_a12`.
Over the evaluations: :func:`convergence`, :func:`targets`, :func:`target_table`, :func:`hitting_times`,
:func:`expected_running_time`, :func:`ecdf`, :func:`aocc`. And :func:`coverage`, :func:`timing`, :func:`feasibility`,
:func:`integrity`.

The modules of this package have what else the harness computes.

Arguments mean the same everywhere: ``frame`` is the tidy frame, ``traces`` are those of its trials, by (problem,
optimizer, trial); ``optima`` the best known objective values, by problem, of the problems where one is known;
``summary`` comes from :func:`summarise`, ``pairs`` from :func:`pairwise_tests`, ``hits`` from :func:`hitting_times`;
``alpha`` is the level of a test, ``tau`` a target, and ``seed`` repeats the resamples of a bootstrap.

Example:
    >>> results = bench.Results("results/runs/thesis")
    >>> frame = in_study_order(results.frame, results.study)
    >>> ranked = order(chances(frame))
    >>> compare(frame, ranked["optimizer"].iloc[0], before=False)
    >>> hits = hitting_times(frame, results.traces, targets(results.traces), results.study.budget.number)
    >>> expected_running_time(hits)
"""

from inspect import isfunction

from bench.analysis.anytime import convergence, ecdf, evaluation_grid, expected_running_time, hitting_times
from bench.analysis.cells import Budgets, Traces, coverage, in_study_order, labels, regret, scores, summarise, timing
from bench.analysis.comparison import chances, compare, order, wins_all
from bench.analysis.direction import ALPHA, a12
from bench.analysis.dominance import u_scores
from bench.analysis.feasibility import feasibility
from bench.analysis.input import guarded
from bench.analysis.instances import Pooled, pool_instances
from bench.analysis.integrity import integrity
from bench.analysis.matrix import comparison_matrix, medians, table
from bench.analysis.pairwise import effect_size, holm, pairwise_tests
from bench.analysis.power import detectable_a12
from bench.analysis.target_sets import aocc, target_table, targets
from bench.study.targets import PRECISIONS, RUN_LENGTHS

__all__ = [
    "ALPHA",
    "PRECISIONS",
    "RUN_LENGTHS",
    "Budgets",
    "Pooled",
    "Traces",
    "a12",
    "aocc",
    "chances",
    "compare",
    "comparison_matrix",
    "convergence",
    "coverage",
    "detectable_a12",
    "ecdf",
    "effect_size",
    "evaluation_grid",
    "expected_running_time",
    "feasibility",
    "hitting_times",
    "holm",
    "in_study_order",
    "integrity",
    "labels",
    "medians",
    "order",
    "pairwise_tests",
    "pool_instances",
    "regret",
    "scores",
    "summarise",
    "table",
    "target_table",
    "targets",
    "timing",
    "u_scores",
    "wins_all",
]

for _name in __all__:
    if isfunction(globals()[_name]):
        globals()[_name] = guarded(globals()[_name])
