"""Foresee the differences that a study's tests can detect, from its design alone, before any trial."""

from __future__ import annotations

from collections import Counter
from math import comb, isnan

from bench import analysis
from bench.analysis.error_rates import detectable_across, enough_trials
from bench.analysis.error_rates import levels as levels_of
from bench.analysis.trials_needed import POWER
from bench.families import function_of
from bench.report.wording import count
from bench.study import Study

MORE = 10  # trials, or problems, that are added


def foreseen(study: Study, power: float = POWER) -> list[str]:
    """Return sentences on the smallest A12 that a study's tests find with a power, as it is and with more of it.

    Two normal samples of one spread are assumed, as in the part *Power* of a report. The instances of a function count
    as trials of one problem.
    """
    of_function = Counter(function_of(entry.label) for entry in study.problems)
    k, problems, instances = len(study.optimizers), len(of_function), min(of_function.values())
    trials = study.trials * instances
    alone = bool(study.subject)
    pairs = k - 1 if alone else comb(k, 2)
    words = f"{count(k, 'optimizer')}, {count(problems, 'problem')}, {count(trials, 'trial')} of each on a problem"
    words += f" ({study.trials:,} on each of {instances:,} instances)" if instances > 1 else ""
    of = f", {study.subject} against each other one" if alone else ""
    lines = [f"The design: {words}{of}; no result is known.", f"As it is: {_found(trials, problems, pairs, power)}."]
    each = f" on each instance, {trials + MORE * instances:,} on a problem" if instances > 1 else ""
    return [
        *lines,
        f"With {MORE} more trials{each}: {_found(trials + MORE * instances, problems, pairs, power)}.",
        f"With {MORE} more problems: {_found(trials, problems + MORE, pairs, power)}.",
    ]


def _found(trials: int, problems: int, pairs: int, power: float) -> str:
    """Return the smallest A12 that the tests on problems, and those over all of them, find, or what they would need."""
    levels = levels_of([trials] * problems, pairs, pairs * problems)
    single = analysis.detectable_a12(trials, levels.problems / (pairs * problems), power) if levels.problems else 0.0
    across = detectable_across(trials, problems, levels.across / pairs, power) if levels.across else 0.0
    enough, _ = enough_trials(problems, pairs, pairs * problems)
    few = f", where {enough} trials of each are the fewest that can be significant" if trials < enough else ""
    one = f"an A12 of {single:.2f}" if single and not isnan(single) else f"nothing{few}"
    every = f"an A12 of {across:.2f} that is the same on each" if across and not isnan(across) else "nothing"
    return f"found with a power of {power:.0%}: on a single problem {one}; over all problems {every}"
