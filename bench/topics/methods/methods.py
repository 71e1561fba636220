"""One paragraph for the methods section of a paper: what was run and tested, and the works that it cites."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.analysis import ALPHA
from bench.analysis.cells import scores, stopped_early
from bench.helpers.bibtex import Work, parse, read
from bench.helpers.errors import BenchError
from bench.helpers.parsing import JsonObject
from bench.report.latex import prose
from bench.report.wording import count, listing, options
from bench.study import Study
from bench.study.descriptions import Description
from bench.study.study import UNKNOWN_BUDGET
from bench.topics.answer.changes import extended
from bench.topics.answer.facts import facts
from bench.topics.answer.section import nothing_to_compare
from bench.topics.course import curves as course
from bench.topics.findings import Findings, Trials
from bench.topics.findings.replication import each_problem

BIBLIOGRAPHY = "references.bib"  # the file of the cited works, beside the methods
NEUTRAL = ("joblib", "matplotlib", "pandas", "seaborn")  # packages on which no trial's result depends
MOST_OPTIMIZERS, MOST_PROBLEMS, MOST_PACKAGES, MOST_WORDS = 6, 4, 6, 30  # named, and words on parameters


Keys = dict[str, list[str]]  # of works, by optimizer
Piece = str | tuple[str, ...]  # a text, or the keys of works that are cited after it


@dataclass(frozen=True)
class Methods:
    """The paragraph as text, Markdown and LaTeX, the BibTeX of what it cites, and a warning for each unreadable one."""

    text: str
    markdown: str
    latex: str
    bibtex: str
    warnings: tuple[str, ...]


def methods(findings: Findings) -> Methods:
    """Return the methods of a run; every sentence holds for that run."""
    study, trials = findings.study, findings.trials
    works, works_of, warnings = bibliography(study, findings.descriptions)
    pieces = [*compared(study, trials, works_of), findings.selection, parameters(study), *runs(trials)]
    pieces += [scored(study, trials), *tested(findings)]
    pieces += reached(findings)
    pieces += machine(findings.results.environments)
    title = json.dumps(_markdown(f"Methods: {study.title or study.name}"), ensure_ascii=False)
    keys = sorted({key for piece in pieces if isinstance(piece, tuple) for key in piece})
    text = _written(pieces, str, lambda keys: f" ({'; '.join(works[key].author_year for key in keys)})")
    markdown = _written(pieces, _markdown, lambda keys: " [" + "; ".join(f"@{key}" for key in keys) + "]")
    markdown = f"---\ntitle: {title}\nbibliography: {BIBLIOGRAPHY}\n---\n\n{markdown}\n"
    latex = _written(pieces, prose, lambda keys: f"~\\cite{{{','.join(keys)}}}")
    latex = f"% {BIBLIOGRAPHY} has the works cited\n{{\\emergencystretch=1em\n\n{latex}\\par}}\n"
    return Methods(text, markdown, latex, "\n".join(works[key].bibtex + "\n" for key in keys), warnings)


def compared(study: Study, trials: Trials, works_of: Mapping[str, Sequence[str]]) -> list[Piece]:
    """Return the sentence on the problems, and on the optimizers with their works."""
    suites = {str(trials.known[label].features.get("suite", "")) for label in trials.problems}
    whole = len(trials.problems) > MOST_PROBLEMS and "" not in suites
    where = f"of {listing(sorted(suites))}" if whole else f"({listing(trials.problems, at_most=MOST_PROBLEMS)})"
    dimensions = [str(d) for d in sorted(set(trials.dimensions.values()))]
    where += f" in dimension {listing(dimensions).replace(' and ', ' or ')}" if dimensions else ""
    begin, more = f"We ran {count(len(study.optimizers), 'optimizer')}", len(study.optimizers) - MOST_OPTIMIZERS
    pieces: list[Piece] = [f"{begin} on {count(len(trials.problems), 'problem')} {where}:"]
    for place, entry in enumerate(study.optimizers[:MOST_OPTIMIZERS]):
        last = place and more <= 0 and place == len(study.optimizers) - 1
        pieces += [f"{' and' if last else ',' * bool(place)} {entry.label}", tuple(works_of[entry.label])]
    return [*pieces, f" and {count(more, 'other')}." if more > 0 else "."]


def parameters(study: Study) -> str:
    """Return the sentences on parameters that have not their default values, and on results of others."""
    alike: dict[str, list[str]] = {}
    for entry in study.optimizers:
        alike.setdefault(options(entry.options), []).append(entry.label)
    given = "; ".join(f"{listing(labels, at_most=len(labels))} with {text}" for text, labels in alike.items() if text)
    made = f"The results of {listing(study.imported)} were made elsewhere and imported." if study.imported else ""
    if len(study.imported) == len(study.optimizers):
        return made
    if len(given.split()) > MOST_WORDS:
        return f"{made} The study's file has every parameter that has not its default value.".lstrip()
    own = f"We ran {given}; all other" if given else "All other" if study.imported else "All"
    return f"{made} {own} parameters have their default values.".lstrip()


def runs(trials: Trials) -> list[str]:
    """Return the sentences on trials, budgets and seed, and on trials that failed, ended early or are not compared."""
    study, skipped = trials.study, trials.comparable
    budgets = {label: budget.words for label, budget in trials.results.budgets.items()}
    each = listing([f"{words} for {label}" for label, words in budgets.items()], at_most=3)
    budget = each if len(set(budgets.values())) > 1 else study.budget_words
    made = each_problem(trials.replications, "independent trial").removesuffix(" each")
    made += " on each problem" * (len(trials.replications) == 1)
    spent = "of unknown length" if study.budget_words == UNKNOWN_BUDGET else f"each with a budget of {budget}"
    said = [f"Of each optimizer we have {made}, {spent}."]
    if len(study.imported) < len(study.optimizers):
        said.append(f"The seed of the study is {study.seed}.")
    if trials.common:
        said.append(f"As budgets differ, we compare values {trials.common_words}.")
    if skipped.failed:
        said.append(f"Not compared, as the problem's own code raised in a trial: {listing(list(skipped.failed))}.")
    added = dict.fromkeys(filter(None, map(extended, trials.results.histories)))
    said += [f"Trials were extended from {first:,} to {most:,} of each." for first, most in added]
    early = trials.frame.loc[stopped_early(trials.frame), "optimizer"].astype(object).value_counts(sort=False)
    if len(early):
        stopped = listing([f"{count(number, 'trial')} of {label}" for label, number in early.items()], at_most=4)
        said.append(f"{stopped} met a stopping criterion of the optimizer before the budget was spent.")
    if failed := int(np.isinf(scores(skipped.working)).sum()):
        said.append(f"{count(failed, 'trial')} failed or found no finite value, which is worse than any value.")
    return said


def scored(study: Study, trials: Trials) -> str:
    """Return the sentence on the value of a trial: what is minimised, under which constraints and noise."""
    known = [trials.known[label] for label in trials.problems]
    measures = {problem.measure for problem in known}
    said = "The score of a trial is the lowest objective value that it found"
    said += f", {measures.pop()}" if len(measures) == 1 and all(measures) else ""
    said += ", less the optimum where instances are pooled" if trials.precisions else ""
    said += ", without noise" if any(problem.noisy for problem in known) else ""
    handled = f"; the handling of constraints is {study.rules.constraints}" * any(
        each.constraints != "" for each in known
    )
    return f"{said}{handled}."


def tested(findings: Findings) -> list[Piece]:
    """Return the sentences on the comparison of optimizers, over all problems and on each; none without rivals."""
    if nothing_to_compare(findings):
        return []
    known = findings.of(facts)
    chance = ", the chance that a trial of one ends lower than one of the other, ties half"
    pieces: list[Piece] = [f"We compare {known.chosen} with each other optimizer by A12", ("vargha2000",), f"{chance}."]
    if not known.tested:
        return [*pieces, "With these trials nothing is tested."]
    level = f"{float(known.rivals['level'].iloc[0]):.2g}"
    each = f"at {level} each" if known.is_subject else f"each at {level}; a winner is named where all tests reject"
    pieces += ["We test that its mean over the problems is 0.5, for unequal spreads", ("delong1988", "schuurhuis2025")]
    pairs = "these pairs" if findings.final.subject else "all pairs"
    pieces += [f", {each}.", f"On each problem we test {pairs} likewise, by Holm's method", ("holm1979",)]
    return [*pieces, f" within the problem at {ALPHA:g}."]


def reached(findings: Findings) -> list[Piece]:
    """Return the sentence on the targets reached over the budget; none where no run left a trace."""
    if not findings.trials.traces or findings.of(course.compared).hits.empty:
        return []
    suite = len(findings.trials.suite_functions) == len(findings.trials.problems)
    bands = " with bands that hold at all budgets together (95%)" * findings.of(course.compared).banded
    times: list[Piece] = [" and expected running times", ("hansen2021",)] if suite else []
    targets = f" (targets: {findings.anytime.target_set.short})."
    return [f"We report the share of targets reached over the budget{bands}", *times, targets]


def machine(environments: Sequence[JsonObject]) -> list[Piece]:
    """Return the sentence on versions and processors."""
    records = [{"Python": each.get("python"), **(each.get("packages") or {})} for each in environments]
    versions = {name: _distinct(each.get(name) for each in records) for record in records for name in record}
    used = [f"{name} {' and '.join(found)}" for name, found in versions.items() if found and name not in NEUTRAL]
    cited = [key for name, key in (("numpy", "harris2020"), ("scipy", "virtanen2020")) if versions.get(name)]
    processors = listing(_distinct(each.get("processor") for each in environments), at_most=3)
    named = listing(used[:MOST_PACKAGES], at_most=MOST_PACKAGES)
    pieces: list[Piece] = [f"The trials used {named}", tuple(cited), " on " * bool(processors) + f"{processors}."]
    return pieces if used else []


def bibliography(study: Study, found: Mapping[str, Description]) -> tuple[dict[str, Work], Keys, tuple[str, ...]]:
    """Return all works by key, the keys of each optimizer's works, and warnings; a taken key gets a number."""
    taken = {key.lower(): work for key, work in read(Path(__file__).with_name(BIBLIOGRAPHY)).items()}
    works_of, warnings = {entry.label: list[str]() for entry in study.optimizers}, []
    for label, keys in works_of.items():
        try:
            own = parse(found.get(label, Description()).bibtex)
        except BenchError as error:
            warnings.append(f"{label} is not cited: {error}.")
            continue
        for work in own:
            number, candidate = 1, work
            while not taken.get(candidate.key.lower(), candidate).is_same(candidate):
                number += 1
                candidate = replace(work, key=f"{work.key}-{number}")
            taken[candidate.key.lower()] = candidate
            keys.append(candidate.key)
    return {work.key: work for work in taken.values()}, works_of, tuple(warnings)


def _written(pieces: Sequence[Piece], plain: Callable[[str], str], cite: Callable[[Sequence[str]], str]) -> str:
    """Return the paragraph, with a space before a piece that begins a sentence."""
    written = ""
    for piece in filter(None, pieces):
        if isinstance(piece, str):
            written += " " * (bool(written) and piece[0] not in " ,.;") + plain(re.sub(r"\s+", " ", piece))
        else:
            written += cite(piece)
    return written


def _distinct(values: Iterable[object]) -> list[str]:
    return list(dict.fromkeys(map(str, filter(None, values))))


def _markdown(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>#@~^$|&\"'])", r"\\\1", text)
