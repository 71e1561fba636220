"""Statistics of a study: pure functions from the tidy frame (:func:`bench.load_results`) to tables; no plotting.

Problem by problem, at the end of the budget: :func:`summarise`, :func:`pairwise_tests`, :func:`compact_letters`,
:func:`standings`, :func:`comparison_matrix`, :func:`ranking`, :func:`disagreements`, :func:`near_best`, :func:`regret`.
Across problems: :func:`across_problems`, :func:`places`, :func:`medians`, :func:`ranks_by_block`, :func:`friedman`,
:func:`interquartile_mean`, :func:`u_scores`, :func:`ranking_certainty`. How often such claims are wrong:
:func:`levels`, :func:`rates_of_equals`, :func:`rates_of_spreads`, :func:`detectable_a12`, :func:`detectable_across`,
:func:`trials_to_separate`. One optimizer against its rivals: :func:`in_parts`, :func:`seen_from`, :func:`signs_of`,
:func:`outcome`. Over the evaluations: :func:`stage_ranks`, :func:`earlier_leads`, :func:`unused_budget`,
:func:`convergence`, :func:`targets`, :func:`precision_targets`, :func:`target_table`, :func:`hitting_times`,
:func:`tolerance_times`,
:func:`expected_running_time`, :func:`running_times`, :func:`in_seconds`, :func:`parallel_times`,
:func:`parallel_ranks`, :func:`ecdf`, :func:`restart_shares`,
:func:`data_profiles`, :func:`success_rates`, :func:`aocc`, :func:`target_areas`, :func:`compare_sets`. Which optimizers
to take: :func:`target_shares`, :func:`portfolio_of`, :func:`shapley`, :func:`validated_selection`,
:func:`selection_gain`, :func:`best_on`. And :func:`timing`, :func:`feasibility`, :func:`integrity`.

Arguments mean the same everywhere: ``frame`` is the tidy frame, ``traces`` are those of its trials, by (problem,
optimizer, trial); ``optima`` the best known objective values, by problem, of the problems where one is known;
``summary`` comes from :func:`summarise`, ``pairs`` from :func:`pairwise_tests`, ``hits`` from :func:`hitting_times`;
``alpha`` is the level of a test, ``tau`` a target, and ``seed`` repeats the resamples of a bootstrap.

Example:
    >>> results = bench.Results("results/runs/thesis")
    >>> frame = in_study_order(results.frame, results.study)
    >>> pairs = pairwise_tests(frame)
    >>> ranking(summarise(frame), pairs)
    >>> hits = hitting_times(frame, results.traces, targets(results.traces), results.study.budget.number)
    >>> expected_running_time(hits)
"""

from inspect import isfunction

from bench.analysis.across import (
    across_problems,
    cliques,
    friedman,
    interquartile_mean,
    nemenyi,
    normalised_errors,
    places,
    ranks_by_block,
    with_winner,
)
from bench.analysis.anytime import (
    best_so_far,
    convergence,
    data_profiles,
    ecdf,
    evaluation_grid,
    expected_running_time,
    hitting_times,
    performance_profiles,
    success_rates,
)
from bench.analysis.bands import curve_bands, leads, profile_bands, spells
from bench.analysis.cells import (
    CONTENTION,
    HIDDEN_THREADS,
    NEAR,
    Budgets,
    Traces,
    budgets,
    cells,
    coverage,
    in_study_order,
    labels,
    near_best,
    reference_values,
    regret,
    scores,
    stopped_early,
    summarise,
    timing,
    variables,
)
from bench.analysis.certainty import rank_stability, ranking_certainty
from bench.analysis.compare import compact_letters, comparison_matrix, medians, ranking, table
from bench.analysis.competition import checkpoint_shares, checkpoints, error_statistics, rank_sum, signs
from bench.analysis.direction import ALPHA, a12
from bench.analysis.dominance import u_scores
from bench.analysis.error_rates import (
    Levels,
    detectable_a12,
    detectable_across,
    enough_trials,
    levels,
    rates_of_equals,
    rates_of_spreads,
    trials_to_separate,
)
from bench.analysis.feasibility import feasibility
from bench.analysis.input import guarded
from bench.analysis.instances import SOLVED, Pooled, pool_instances, precision_targets
from bench.analysis.integrity import integrity
from bench.analysis.kolmogorov_smirnov import TIED
from bench.analysis.looks import Decisions, at_looks, blind_looks, decide
from bench.analysis.multiverse import MULTIVERSE, multiverse
from bench.analysis.pairwise import CUTOFFS, adjusted, effect_size, holm, pairwise_tests
from bench.analysis.parallel import parallel_ranks, parallel_times
from bench.analysis.portfolio import Portfolio, portfolio_of, shapley, target_shares
from bench.analysis.reference import reference_shares, reference_times, runlength_targets
from bench.analysis.running_time import (
    in_seconds,
    mean_shares,
    restart_shares,
    running_times,
    separably_fastest,
    simulated_restarts,
)
from bench.analysis.selection import best_on, selection_gain, validated_selection
from bench.analysis.stages import SHARES, earlier_leads, stage_ranks, unused_budget
from bench.analysis.standings import disagreements, mean_ranks, standings
from bench.analysis.subject import in_parts, outcome, seen_from, signs_of
from bench.analysis.target_sets import (
    aocc,
    compare_sets,
    target_areas,
    target_table,
    targets,
    tolerance_times,
)
from bench.analysis.trials_needed import POWER, trials_needed
from bench.study.targets import COCO_PRECISIONS, PRECISIONS, RUN_LENGTHS, fractions

__all__ = [
    "ALPHA",
    "COCO_PRECISIONS",
    "CONTENTION",
    "CUTOFFS",
    "HIDDEN_THREADS",
    "MULTIVERSE",
    "NEAR",
    "POWER",
    "PRECISIONS",
    "RUN_LENGTHS",
    "SHARES",
    "SOLVED",
    "TIED",
    "Budgets",
    "Decisions",
    "Levels",
    "Pooled",
    "Portfolio",
    "Traces",
    "a12",
    "across_problems",
    "adjusted",
    "aocc",
    "at_looks",
    "best_on",
    "best_so_far",
    "blind_looks",
    "budgets",
    "cells",
    "checkpoint_shares",
    "checkpoints",
    "cliques",
    "compact_letters",
    "compare_sets",
    "comparison_matrix",
    "convergence",
    "coverage",
    "curve_bands",
    "data_profiles",
    "decide",
    "detectable_a12",
    "detectable_across",
    "disagreements",
    "earlier_leads",
    "ecdf",
    "effect_size",
    "enough_trials",
    "error_statistics",
    "evaluation_grid",
    "expected_running_time",
    "feasibility",
    "fractions",
    "friedman",
    "hitting_times",
    "holm",
    "in_parts",
    "in_seconds",
    "in_study_order",
    "integrity",
    "interquartile_mean",
    "labels",
    "leads",
    "levels",
    "mean_ranks",
    "mean_shares",
    "medians",
    "multiverse",
    "near_best",
    "nemenyi",
    "normalised_errors",
    "outcome",
    "pairwise_tests",
    "parallel_ranks",
    "parallel_times",
    "performance_profiles",
    "places",
    "pool_instances",
    "portfolio_of",
    "precision_targets",
    "profile_bands",
    "rank_stability",
    "rank_sum",
    "ranking",
    "ranking_certainty",
    "ranks_by_block",
    "rates_of_equals",
    "rates_of_spreads",
    "reference_shares",
    "reference_times",
    "reference_values",
    "regret",
    "restart_shares",
    "runlength_targets",
    "running_times",
    "scores",
    "seen_from",
    "selection_gain",
    "separably_fastest",
    "shapley",
    "signs",
    "signs_of",
    "simulated_restarts",
    "spells",
    "stage_ranks",
    "standings",
    "stopped_early",
    "success_rates",
    "summarise",
    "table",
    "target_areas",
    "target_shares",
    "target_table",
    "targets",
    "timing",
    "tolerance_times",
    "trials_needed",
    "trials_to_separate",
    "u_scores",
    "unused_budget",
    "validated_selection",
    "variables",
    "with_winner",
]

for _name in __all__:
    if isfunction(globals()[_name]):
        globals()[_name] = guarded(globals()[_name])
