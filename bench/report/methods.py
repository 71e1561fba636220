"""The methods section of a paper about a study: sentences that hold for the actual run, and the works they cite."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.analysis import ALPHA, TIED, Levels
from bench.analysis.across import FEWER, MANY
from bench.analysis.cells import NEAR
from bench.analysis.certainty import resamples as rank_resamples
from bench.analysis.equivalence import RESAMPLES as EQUIVALENCE_RESAMPLES
from bench.analysis.instances import SOLVED
from bench.analysis.pairwise import RESAMPLES
from bench.errors import BenchError
from bench.execution.descriptions import Description
from bench.helpers.bibtex import Work, parse, read
from bench.report import problem_words
from bench.report.conditions import conditions
from bench.report.latex import escape
from bench.report.replication import Replication, each_problem
from bench.report.target_words import TargetWords, target_words
from bench.report.winner import WINNER_RULE
from bench.report.wording import count, listing, options
from bench.scoring.constraints import COEFFICIENT
from bench.storage.results import ProblemFacts
from bench.study import Study
from bench.study.budget import described
from bench.study.rope import Rope
from bench.study.tuned import Tuning

BIBLIOGRAPHY = "references.bib"  # the file of the cited works, beside the methods

NEUTRAL = ("joblib", "matplotlib", "pandas", "seaborn")
"""Packages on which no trial's result depends: they schedule trials, keep tables and draw."""

ON_PROBLEMS = Levels(ALPHA, 0.0)

_CITATION = re.compile(r" \[@([^]]+)\]")


@dataclass(frozen=True)
class MethodsFacts:
    """The facts about a run that its methods section states.

    Attributes:
        study: the study as planned.
        replications: the trials of the cells (problem and optimizer), by the instances that a problem stands for.
        known: the facts of the problems, by label.
        empty: cells without any trial.
        failed: trials that failed, of all.
        descriptions: each optimizer as its plug-in describes it, by label; one without BibTeX is not cited.
        environments: what each run recorded of itself and its machine (:mod:`bench.storage.provenance`).
        tests: tests of pairs of optimizers on problems, 0 where none can be significant.
        pairs: the pairs of optimizers over all problems.
        levels: of the tests on problems and across them.
        blocks: the independent problems.
        permutation_tests: the Kolmogorov-Smirnov tests that use the permutation distribution given the ties.
        ranked_problems: problems that entered the comparison across problems.
        known_optima: problems whose optimum is known.
        targets: problems that have targets.
        early: trials that stopped by a criterion of their own before their budget was spent, by optimizer.
        checks: what ``bench check`` found of each optimizer, by label; the methods say what it looked for.
        rope: the region of practical equivalence, where a report has one.
        landscapes: problems whose landscapes were described by features.
        dominance: problems on which U-scores compare the optimizers.
        target_set: the words for the targets.
        aocc: problems on which the area over the convergence curve is given.
        budgets: the budget of each optimizer in words, by label, where it may not be the study's.
        common: the words for the budget at which values are compared, where budgets differ.
        confined: problems whose optimum some optimizers cannot reach.
        best2009: problems on which the best of 2009 stands beside the optimizers.
        sweeps: sweeps whose parameters' contributions are given.
        tuning: how the optimizers were tuned, where this harness did and the record is as it was written.
        stopped: cells that a declared look stopped.
        extensions: the trials of each cell that were complete, and those then asked for without declared looks.
        needed: how the trials that would separate more pairs were estimated, "simulation" or "formula"; "" where none.
        stability: whether ranks are given over the number of trials.
    """

    study: Study
    replications: Sequence[Replication]
    known: Mapping[str, ProblemFacts] = field(default_factory=dict)
    empty: int = 0
    failed: int = 0
    descriptions: Mapping[str, Description] = field(default_factory=dict)
    environments: Sequence[Mapping[str, Any]] = ()
    tests: int = 0
    pairs: int = 0
    levels: Levels = ON_PROBLEMS
    blocks: int = 0
    permutation_tests: int = 0
    ranked_problems: int = 0
    known_optima: int = 0
    targets: int = 0
    early: Mapping[str, int] = field(default_factory=dict)
    checks: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    rope: Rope | None = None
    landscapes: int = 0
    dominance: int = 0
    target_set: TargetWords = field(default_factory=lambda: target_words("relative"))
    aocc: int = 0
    budgets: Mapping[str, str] = field(default_factory=dict)
    common: str = ""
    confined: int = 0
    best2009: int = 0
    sweeps: int = 0
    tuning: Tuning | None = None
    stopped: int = 0
    extensions: Sequence[tuple[int, int]] = ()
    needed: str = ""
    stability: bool = False


@dataclass(frozen=True)
class Methods:
    """The same sentences in three formats.

    Attributes:
        text: plain paragraphs, which cite by author and year.
        markdown: paragraphs with citations and front matter for pandoc.
        latex: paragraphs for ``\\input``.
        bibtex: the works cited, in alphabetical order of their keys.
        warnings: a sentence for each optimizer that is not cited, because its BibTeX cannot be read.
    """

    text: tuple[str, ...]
    markdown: str
    latex: str
    bibtex: str
    warnings: tuple[str, ...]


def methods(facts: MethodsFacts) -> Methods:
    """Return the methods section of a run; every sentence in it holds for that run."""
    works, own, warnings = _bibliography(facts)
    prose = paragraphs(templates().get_template("methods.j2").render(_context(facts), own=own))
    title = json.dumps(MARKDOWN.plain(f"Methods: {facts.study.title or facts.study.name}"), ensure_ascii=False)
    front = f"---\ntitle: {title}\nbibliography: {BIBLIOGRAPHY}\n---"
    comment = f"% {BIBLIOGRAPHY} has the works cited"
    return Methods(
        text=tuple(TEXT.write(each, works) for each in prose),
        markdown="\n\n".join([front, *(MARKDOWN.write(each, works) for each in prose)]) + "\n",
        latex="\n\n".join([comment, *(LATEX.write(each, works) for each in prose)]) + "\n",
        bibtex="\n".join(works[key].bibtex + "\n" for key in cited_keys(prose)),
        warnings=warnings,
    )


def _context(facts: MethodsFacts) -> dict[str, Any]:
    """Return what the template refers to by name."""
    alike: dict[str, list[str]] = {}
    for entry in facts.study.optimizers:
        alike.setdefault(options(entry.options), []).append(entry.label)
    budgets: dict[str, list[str]] = {}
    for label, words in facts.budgets.items():
        budgets.setdefault(words, []).append(label)
    known = facts.known
    pooled = [own for own in facts.replications if own.instances > 1]
    return vars(facts) | {
        "pooled": sum(own.problems for own in pooled),
        "instances": listing([f"{own.instances}" for own in pooled]) if pooled else "",
        "fewest": min((own.fewest for own in facts.replications), default=0),
        "most": max((own.most for own in facts.replications), default=0),
        "made": _made(facts),
        "constrained": sum(bool(each.constraints) for each in known.values()),
        "noisy": sum(each.noisy for each in known.values()),
        "mixed": sum(bool(each.integers) for each in known.values()),
        "dimensions": problem_words.dimensions(known),
        "boxes": problem_words.boxes(known),
        "optima": problem_words.optima(known),
        "unknown_optima": sum(each.optimum is None for each in known.values()),
        "measures": problem_words.measures(known),
        "steps": problem_words.sweeps(known),
        "handling": _handling(facts),
        "tested": {name: _tested(facts, name) for name in ("centre bias", "structural bias")},
        "budgets": [f"{words} for {listing(labels)}" for words, labels in budgets.items()],
        "count": count,
        "described": described,
        "listing": listing,
        "alpha": ALPHA,
        "near": NEAR,
        "tied": TIED,
        "solved": SOLVED,
        "fewer": len(facts.study.optimizers) > MANY,
        "winner_rule": WINNER_RULE,
        "fewer_resamples": FEWER,
        "resamples": RESAMPLES,
        "rank_resamples": rank_resamples(len(facts.study.optimizers)),
        "equivalence_resamples": EQUIVALENCE_RESAMPLES,
        "coefficient": COEFFICIENT,
        "given": [f"{listing(labels, at_most=len(labels))} with {text}" for text, labels in alike.items() if text],
        "early": [f"{count(number, 'trial')} of {label}" for label, number in facts.early.items() if number],
        "versions": _versions(facts.environments),
        "commits": _commits(facts.environments),
        "processors": _distinct(environment.get("processor") for environment in facts.environments),
    }


def _made(facts: MethodsFacts) -> str:
    """Return how many independent trials were made of an optimizer on a problem."""
    noun = "independent trial"
    if len(facts.replications) > 1:
        return each_problem(facts.replications, noun)
    at_most = facts.study.trials if facts.study.looks else 0
    return "".join(own.words(noun, at_most) for own in facts.replications)


def _handling(facts: MethodsFacts) -> dict[str, str]:
    """Return who has which of the values ``box`` and ``repair`` of the option ``handling``, in words; "" for none."""
    found = conditions(facts.study, facts.descriptions)["handling"]
    owners = {value: [str(label) for label in found.index[found == value]] for value in ("box", "repair")}
    return {value: listing(labels) if labels else "" for value, labels in owners.items()}


def _tested(facts: MethodsFacts, check: str) -> list[str]:
    """Return the optimizers that ``bench check`` tested for a bias."""
    return [label for label, found in facts.checks.items() if any(each["check"] == check for each in found)]


def _versions(environments: Sequence[Mapping[str, Any]]) -> dict[str, list[str]]:
    """Return the versions that made the trials, by package."""
    found: dict[str, list[str]] = {}
    for environment in environments:
        for name, version in {"Python": environment.get("python"), **(environment.get("packages") or {})}.items():
            if version and name not in NEUTRAL:
                found[name] = _distinct([*found.get(name, []), str(version)])
    return found


def _commits(environments: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a clause on the commits of each checkout that has any."""
    states: dict[str, list[Mapping[str, Any]]] = {}
    for environment in environments:
        for name, git in {"source code": environment.get("git"), **(environment.get("checkouts") or {})}.items():
            states.setdefault(name, []).extend([git] if git else [])
    clauses = []
    for name, found in states.items():
        if commits := _distinct(str(state.get("commit") or "")[:10] for state in found):
            changed = ", with local changes" if any(state.get("dirty") for state in found) else ""
            clauses.append(f"{name} at commit {listing(commits)}{changed}")
    return clauses


def _distinct(values: Iterable[Any]) -> list[str]:
    return list(dict.fromkeys(filter(None, values)))


def library() -> dict[str, Work]:
    """Return the works whose methods the reports use, by key."""
    return read(Path(__file__).with_name(BIBLIOGRAPHY))


def _bibliography(facts: MethodsFacts) -> tuple[dict[str, Work], dict[str, list[str]], tuple[str, ...]]:
    """Return all works by key, the keys of each optimizer's works by label, and warnings."""
    works, own, warnings = list(library().values()), {}, []
    for entry in facts.study.optimizers:
        try:
            references = parse(facts.descriptions.get(entry.label, Description()).bibtex)
        except BenchError as error:
            references = []
            warnings.append(f"{entry.label} is not cited: {error}.")
        works, named = merge_works(works, references)
        own[entry.label] = [work.key for work in named]
    return {work.key: work for work in works}, own, tuple(warnings)


def merge_works(works: list[Work], others: list[Work]) -> tuple[list[Work], list[Work]]:
    """Return ``works`` with those of ``others`` that they lack, and ``others`` under their keys in that list.

    BibTeX ignores the case of keys, so a number is appended to the key of another work whose key is taken.
    """
    taken = {work.key.lower(): work for work in works}
    named = []
    for other in others:
        number, each = 1, other
        while not taken.get(each.key.lower(), each).is_same(each):
            number += 1
            each = replace(other, key=f"{other.key}-{number}")
        taken[each.key.lower()] = each
        named.append(each)
    return list(taken.values()), named


@cache
def templates() -> Environment:
    """Return the templates of prose; ``[@key; @key]`` after a space in their text cites works."""
    return Environment(
        loader=PackageLoader("bench.report", ""),
        undefined=StrictUndefined,
        finalize=_data,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _data(value: Any) -> str:
    """Return a value for a template such that no part of it reads as a citation or ends the paragraph."""
    return value if isinstance(value, Markup) else _one_line(str(value)).replace("[", "[[")


def paragraphs(filled: str) -> list[str]:
    """Return the paragraphs of a filled template, each as one line; blank lines separate them."""
    return [" ".join(each.split()) for each in re.split(r"\n\s*\n", filled) if each.strip()]


def cited_keys(prose: Sequence[str]) -> list[str]:
    """Return the keys that the paragraphs cite, in alphabetical order."""
    return sorted({key for each in prose for keys in _CITATION.findall(each) for key in keys.split("; @")})


@dataclass(frozen=True)
class Style:
    """A way to write prose: how plain text is escaped and how one or more works are cited."""

    plain: Callable[[str], str]
    cite: Callable[[list[Work]], str]

    def write(self, prose: str, works: Mapping[str, Work]) -> str:
        """Return a paragraph of a filled template; ``works`` are those it may cite, by key."""
        pieces = _CITATION.split(prose)  # every second piece holds keys
        pieces[::2] = [self.plain(piece.replace("[[", "[")) for piece in pieces[::2]]
        pieces[1::2] = [self.cite([works[key] for key in keys.split("; @")]) for keys in pieces[1::2]]
        return "".join(pieces)


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def _escape_markdown(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>#@~^$|&\"'])", r"\\\1", _one_line(text))


TEXT = Style(str, lambda works: f" ({'; '.join(work.author_year for work in works)})")
MARKDOWN = Style(_escape_markdown, lambda works: f" [{'; '.join(f'@{work.key}' for work in works)}]")
LATEX = Style(escape, lambda works: f"~\\cite{{{','.join(work.key for work in works)}}}")
