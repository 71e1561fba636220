"""Recommend an optimizer for a problem from the trials of others on similar problems, and the study that tests it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import pandas as pd

from bench.analysis.landscape import describe
from bench.analysis.portfolio import HalfScores, best_gap
from bench.analysis.selection import NEIGHBOURS, best_on, cell_scores, feature_distances, single_best, usual_reach
from bench.errors import BenchError
from bench.plugins.loading import is_imported, load_problem
from bench.problem import Problem
from bench.report.wording import count, listing
from bench.results.results import StoredResults
from bench.study import Study
from bench.study.budget import Budget
from bench.topics.findings import Findings
from bench.topics.landscapes.features import sample
from bench.topics.portfolio.choice import Choice, gap_sentence, selection_sentence

TRIALS = 15  # of the study that tests an advice


@dataclass(frozen=True)
class Recommendation:
    """An optimizer for a problem, and what it rests on.

    Attributes:
        optimizer: the label of the one to take: the best on the most similar problems where such a choice is shown to
            be better than the single best, else the single best.
        nearest: problem, distance and ``best`` (its best optimizer) of the most similar problems; empty where none
            could be compared.
        best: the best three optimizers there, or on all problems where ``nearest`` is empty
            (:func:`bench.analysis.best_on`).
        notes: sentences on what the recommendation rests on, the most important last.
        study: the study that compares these optimizers and the single best on the problem; None where none of them can
            be run.
    """

    optimizer: str
    nearest: pd.DataFrame
    best: pd.DataFrame
    notes: tuple[str, ...]
    study: Study | None


def recommend(
    problem: str,
    folders: Sequence[str | PathLike[str]],
    budget: Any,
    options: Mapping[str, Any] | None = None,
    name: str = "recommended",
) -> Recommendation:
    """Return an optimizer for a problem from the trials in the folders; evaluate a sample of the problem.

    Args:
        problem: its name, or ``"file.py:Class"``.
        folders: of studies that can be compared.
        budget: the evaluations to spend (:meth:`bench.study.budget.Budget.read`), those of the sample among them.
        options: of the problem.
        name: of the study.

    Raises:
        BenchError: where a folder, the problem or the budget cannot be used, or the folders have no trials to compare.
    """
    asked = Budget.read(budget, "--budget")
    loaded = load_problem(problem, **options or {})
    spent, cost = asked.evaluations(loaded.dimension), sample(loaded.dimension)
    findings = Findings(StoredResults(*folders))
    choice = Choice(findings, asked)
    notes = _budget_notes(choice, asked.words)
    if len(findings.trials.optimizers) < 2:
        raise BenchError("the folders hold one optimizer, so there is nothing to choose; give others with --from")
    if not (choice.scores["score"] > 0).any():
        raise BenchError(
            f"no trial of the folders reached any target within {asked.words}, so there is nothing to choose by; "
            "give a larger --budget, or others with --from"
        )
    notes.append(gap_sentence(best_gap(HalfScores.of(choice.scores, choice.blocks))))
    plain = cell_scores(choice.scores)
    single = advised = single_best(plain, choice.blocks)
    nearest, where, charged = pd.DataFrame(), list(plain.index), choice.scores
    if obstacle := _obstacle(choice, spent, cost):
        notes.append(f"{obstacle} The advice is the single best on all problems of the folders, {single}.")
    else:
        features = choice.features[choice.features.index.isin(where)]
        of_problem = pd.DataFrame([_features(loaded, cost) | {"dimension": loaded.dimension}], index=[problem])
        near = feature_distances(features, of_problem).iloc[0].nsmallest(NEIGHBOURS)
        winners = [listing(list(row.index[row == row.max()]), 3) for _, row in plain.loc[near.index].iterrows()]
        nearest = pd.DataFrame({"problem": near.index, "distance": near.to_numpy(dtype=float), "best": winners})
        where, charged = list(near.index), choice.charged
        notes += _extrapolation(problem, loaded.dimension, float(near.iloc[0]), features, choice.blocks)
    best = best_on(where, choice.scores, charged, choice.blocks)
    if not obstacle:
        first, reached = str(best["optimizer"].iloc[0]), bool(best["score"].iloc[0] > 0)
        advised = first if choice.pays and reached else single
        notes += [selection_sentence(choice), _advice(first, single, pays=choice.pays, reached=reached)]
    study = _study(name, problem, options or {}, asked, findings, [advised, *best["optimizer"], single])
    return Recommendation(advised, nearest, best, tuple(notes), study)


def _budget_notes(choice: Choice, words: str) -> list[str]:
    """Return sentences on the budgets; raises BenchError where the trials on no problem had as many evaluations."""
    trials = choice.findings.trials
    if not choice.budgets:
        raise BenchError(
            f"the trials of the folders had at most {choice.findings.study.budget_words}, fewer than {words}; ask for "
            "fewer, or run the study with more"
        )
    notes = []
    if left_out := len(trials.problems) - len(choice.budgets):
        notes.append(f"Left out: {count(left_out, 'problem')} whose trials had fewer evaluations than asked for.")
    whole = Choice(choice.findings).budgets
    if any(most < whole[problem] for problem, most in choice.budgets.items()):
        notes.append(
            f"The trials had more evaluations and are looked at after {words}; an optimizer that plans by its budget "
            "may do better with fewer."
        )
    return notes


def _obstacle(choice: Choice, spent: int, cost: int) -> str:
    """Return why nothing can be chosen by features, "" where it can."""
    if spent <= cost:
        return f"The features of the problem would take {cost:,} evaluations, which is all of the budget of {spent:,}."
    described_own = set(choice.features.index) & set(cell_scores(choice.charged).index)
    if not described_own:
        return "No problem of the folders can be loaded and sampled here, so none can be compared by its features."
    return ""


def _extrapolation(
    problem: str, dimension: int, distance: float, features: pd.DataFrame, blocks: Mapping[str, str]
) -> list[str]:
    """Return how the problem is beyond those of the folders, if it is."""
    low, high = (int(end) for end in (features["dimension"].min(), features["dimension"].max()))
    reach = usual_reach(features, blocks)
    beyond = []
    if not low <= dimension <= high:
        sizes = f"{low}" if low == high else f"{low} to {high}"
        beyond.append(f"has {count(dimension, 'variable')}, and the problems of the folders have {sizes}")
    if distance > reach:
        beyond.append(
            f"is at a distance of {distance:.2f} from the most similar problem, and each problem of the folders is "
            f"within {reach:.2f} of one of another function"
        )
    return [f"This is an extrapolation: {problem} {'; it '.join(beyond)}."] if beyond else []


def _features(problem: Problem, points: int) -> dict[str, float]:
    try:
        return describe(problem, points)
    except BenchError:
        raise
    except Exception as error:  # a plug-in may raise anything
        raise BenchError(f"{problem.name} cannot be evaluated: {type(error).__name__}: {error}") from error


def _advice(first: str, single: str, *, pays: bool, reached: bool) -> str:
    if not reached:
        return f"No trial on the most similar problems reached a target, so the advice is {single}, the single best."
    if pays:
        return f"The advice is {first}, the best on the most similar problems."
    if first == single:
        return f"The advice is {single}, the single best, which is also the best on the most similar problems."
    return f"The advice is {single}, the single best; {first}, the best on the most similar problems, is worth a test."


def _study(
    name: str, problem: str, options: Mapping[str, Any], budget: Any, findings: Findings, labels: Sequence[str]
) -> Study | None:
    """Return the study of these optimizers on the problem, without those that cannot be run."""
    entries = {entry.label: entry for entry in findings.results.study.optimizers if not is_imported(entry.name)}
    chosen = [entries[label].as_dict() for label in dict.fromkeys(labels) if label in entries]
    if not chosen:
        return None
    return Study.from_dict(
        {
            "name": name, "title": f"Which optimizer to take for {problem}", "trials": TRIALS, "budget": budget,
            "problems": [{"name": problem, **options}], "optimizers": chosen,
        },
        repr(name),
    )  # fmt: skip
