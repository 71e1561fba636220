"""The methods section of a paper about a study: sentences that hold for the actual run, and the works they cite."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.analysis import ALPHA
from bench.analysis.across import FEWER, MANY
from bench.analysis.cells import NEAR, scores, stopped_early
from bench.analysis.certainty import resamples as rank_resamples
from bench.analysis.instances import SOLVED
from bench.analysis.integrity import undeclared
from bench.analysis.kolmogorov_smirnov import TIED
from bench.analysis.pairwise import RESAMPLES
from bench.errors import BenchError
from bench.helpers.bibtex import Work, parse, read
from bench.report.latex import prose
from bench.report.wording import count, listing, options
from bench.scoring.constraints import COEFFICIENT
from bench.study import Study
from bench.study.descriptions import Description
from bench.topics.conditions.conditions import conditions
from bench.topics.findings import Findings
from bench.topics.findings.replication import Replication, each_problem
from bench.topics.methods import problem_words
from bench.topics.subject.against import against, subject_methods
from bench.topics.verdict.winner import winner_rule

BIBLIOGRAPHY = "references.bib"  # the file of the cited works, beside the methods

NEUTRAL = ("joblib", "matplotlib", "pandas", "seaborn")
"""Packages on which no trial's result depends: they schedule trials, keep tables and draw."""

_CITATION = re.compile(r" \[@([^]]+)\]")


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


def methods(findings: Findings) -> Methods:
    """Return the methods section of a run; every sentence in it holds for that run."""
    return write(findings.study, findings.descriptions, facts(findings))


def facts(findings: Findings) -> dict[str, Any]:
    """Return the facts about a run that its methods state, by the name that the template gives them."""
    results = findings.results
    trials, final, anytime = findings.trials, findings.final, findings.anytime
    early = stopped_early(trials.frame)
    return {
        "selection": findings.selection,
        "replications": trials.replications,
        "within": len(trials.stratified),  # problems compared instance by instance
        "known": trials.known,  # facts of the problems, by label
        "suites": problem_words.suites(trials.known),
        "empty": int((trials.coverage["stored"] == 0).sum()),
        "failed": int(np.isinf(scores(trials.comparable.working)).sum()),
        "not_compared": trials.comparable,
        "environments": results.environments,
        "tests": final.tests if final.levels.problems else 0,  # of which one can be significant
        "pairs": final.tests,
        "levels": final.levels,
        "level_on_problems": final.level_on_problems,
        "permutation_tests": int(final.tested_pairs["ks_tied"].sum()),  # Kolmogorov-Smirnov tests given the ties
        "ranked_problems": len(final.medians),
        "known_optima": int(anytime.targets.drop_duplicates("problem")["known"].sum()),
        "targets": anytime.targets["problem"].nunique(),
        "target_set": anytime.target_set,
        "aocc": anytime.aocc["problem"].nunique() if anytime.target_set.absolute else 0,
        "early": {label: int((early & (trials.frame["optimizer"] == label)).sum()) for label in trials.optimizers},
        "checks": results.checks,
        "subject": subject_methods(findings.of(against)) if findings.subject and len(final.medians) else "",
        "subject_tested": final.subject,
        "dominance": anytime.u_scores["problem"].nunique() if len(trials.optimizers) > 1 else 0,
        "budgets": {label: budget.words for label, budget in results.budgets.items()},
        "common": trials.common_words,
        "confined": len({problem for (problem, _), by in trials.shifts.items() if by}),  # optimum out of reach
        "best2009": anytime.best_times.dropna()["problem"].nunique(),
        "extensions": undeclared(trials.extensions),
        "needed": "" if final.needed.empty else str(final.needed["method"].iloc[0]),
        "stability": len(final.stability) > 0,
    }


def write(study: Study, descriptions: Mapping[str, Description], stated: Mapping[str, Any]) -> Methods:
    """Return the methods section of a study with the facts of :func:`facts`."""
    works, works_of, warnings = _bibliography(study, descriptions)
    context = _context(study, descriptions, stated)
    written = paragraphs(templates().get_template("methods.j2").render(context, own=works_of))
    title = json.dumps(MARKDOWN.plain(f"Methods: {study.title or study.name}"), ensure_ascii=False)
    front = f"---\ntitle: {title}\nbibliography: {BIBLIOGRAPHY}\n---"
    comment = f"% {BIBLIOGRAPHY} has the works cited\n{{\\emergencystretch=1em"
    return Methods(
        text=tuple(TEXT.write(paragraph, works) for paragraph in written),
        markdown="\n\n".join([front, *(MARKDOWN.write(paragraph, works) for paragraph in written)]) + "\n",
        latex="\n\n".join([comment, *(LATEX.write(paragraph, works) for paragraph in written)]) + "\\par}\n",
        bibtex="\n".join(works[key].bibtex + "\n" for key in cited_keys(written)),
        warnings=warnings,
    )


def _context(study: Study, descriptions: Mapping[str, Description], stated: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values that the template refers to, by name."""
    alike: dict[str, list[str]] = {}
    for entry in study.optimizers:
        alike.setdefault(options(entry.options), []).append(entry.label)
    budgets: dict[str, list[str]] = {}
    for label, words in stated["budgets"].items():
        budgets.setdefault(words, []).append(label)
    problem_facts, replications = stated["known"], stated["replications"]
    pooled = [cells for cells in replications if cells.instances > 1]
    return {
        **stated,
        "study": study,
        "pooled": sum(cells.problems for cells in pooled),
        "instances": listing([f"{cells.instances}" for cells in pooled]) if pooled else "",
        "fewest": min((cells.fewest for cells in replications), default=0),
        "most": max((cells.most for cells in replications), default=0),
        "made": _made(replications),
        "constrained": sum(bool(problem.constraints) for problem in problem_facts.values()),
        "noisy": sum(problem.noisy for problem in problem_facts.values()),
        "mixed": sum(bool(problem.integers) for problem in problem_facts.values()),
        "dimensions": problem_words.dimensions(problem_facts),
        "boxes": problem_words.boxes(problem_facts),
        "optima": problem_words.optima(problem_facts),
        "unknown_optima": sum(problem.optimum is None for problem in problem_facts.values()),
        "measures": problem_words.measures(problem_facts),
        "handling": _handling(study, descriptions),
        "tested": {name: _tested(stated["checks"], name) for name in ("centre bias", "structural bias")},
        "budgets": [f"{words} for {listing(labels)}" for words, labels in budgets.items()],
        "count": count,
        "listing": listing,
        "alpha": ALPHA,
        "near": NEAR,
        "tied": TIED,
        "solved": SOLVED,
        "fewer": len(study.optimizers) > MANY,
        "winner_rule": winner_rule(),
        "fewer_resamples": FEWER,
        "resamples": RESAMPLES,
        "rank_resamples": rank_resamples(len(study.optimizers)),
        "coefficient": COEFFICIENT,
        "given": [f"{listing(labels, at_most=len(labels))} with {text}" for text, labels in alike.items() if text],
        "early": [f"{count(number, 'trial')} of {label}" for label, number in stated["early"].items() if number],
        "versions": _versions(stated["environments"]),
        "commits": _commits(stated["environments"]),
        "processors": _distinct(environment.get("processor") for environment in stated["environments"]),
    }


def _made(replications: Sequence[Replication]) -> str:
    """Return how many independent trials were made of an optimizer on a problem."""
    noun = "independent trial"
    if len(replications) > 1:
        return each_problem(replications, noun)
    return "".join(cells.words(noun) for cells in replications)


def _handling(study: Study, descriptions: Mapping[str, Description]) -> dict[str, str]:
    """Return the optimizers by their ``handling``, ``box`` or ``repair``, in words; "" if none has the option."""
    handling = conditions(study, descriptions)["handling"]
    owners = {value: [str(label) for label in handling.index[handling == value]] for value in ("box", "repair")}
    return {value: listing(labels) if labels else "" for value, labels in owners.items()}


def _tested(checks: Mapping[str, Sequence[Mapping[str, Any]]], check: str) -> list[str]:
    """Return the optimizers that ``bench check`` tested for a bias."""
    return [label for label, results in checks.items() if any(result["check"] == check for result in results)]


def _versions(environments: Sequence[Mapping[str, Any]]) -> dict[str, list[str]]:
    """Return the versions that made the trials, by package."""
    versions: dict[str, list[str]] = {}
    for environment in environments:
        for name, version in {"Python": environment.get("python"), **(environment.get("packages") or {})}.items():
            if version and name not in NEUTRAL:
                versions[name] = _distinct([*versions.get(name, []), str(version)])
    return versions


def _commits(environments: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a clause on the commits of each checkout that has any."""
    states: dict[str, list[Mapping[str, Any]]] = {}
    for environment in environments:
        for name, git in {"source code": environment.get("git"), **(environment.get("checkouts") or {})}.items():
            states.setdefault(name, []).extend([git] if git else [])
    clauses = []
    for name, of_checkout in states.items():
        if commits := _distinct(str(state.get("commit") or "")[:10] for state in of_checkout):
            changed = ", with local changes" if any(state.get("dirty") for state in of_checkout) else ""
            clauses.append(f"{name} at commit {listing(commits)}{changed}")
    return clauses


def _distinct(values: Iterable[Any]) -> list[str]:
    return list(dict.fromkeys(filter(None, values)))


def library() -> dict[str, Work]:
    """Return the works whose methods the reports use, by key."""
    return read(Path(__file__).with_name(BIBLIOGRAPHY))


def _bibliography(
    study: Study, descriptions: Mapping[str, Description]
) -> tuple[dict[str, Work], dict[str, list[str]], tuple[str, ...]]:
    """Return all works by key, the keys of each optimizer's works by label, and warnings."""
    works, works_of, warnings = list(library().values()), {}, []
    for entry in study.optimizers:
        try:
            references = parse(descriptions.get(entry.label, Description()).bibtex)
        except BenchError as error:
            references = []
            warnings.append(f"{entry.label} is not cited: {error}.")
        works, named = merge_works(works, references)
        works_of[entry.label] = [work.key for work in named]
    return {work.key: work for work in works}, works_of, tuple(warnings)


def merge_works(works: list[Work], added: list[Work]) -> tuple[list[Work], list[Work]]:
    """Return ``works`` with those of ``added`` that they lack, and ``added`` under their keys in that list.

    BibTeX ignores the case of keys, so a number is appended to the key of another work whose key is taken.
    """
    taken = {work.key.lower(): work for work in works}
    named = []
    for work in added:
        number, candidate = 1, work
        while not taken.get(candidate.key.lower(), candidate).is_same(candidate):
            number += 1
            candidate = replace(work, key=f"{work.key}-{number}")
        taken[candidate.key.lower()] = candidate
        named.append(candidate)
    return list(taken.values()), named


@cache
def templates() -> Environment:
    """Return the templates of prose; ``[@key; @key]`` after a space in their text cites works."""
    return Environment(
        loader=PackageLoader("bench.topics.methods", ""),
        undefined=StrictUndefined,
        finalize=_data,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _data(value: Any) -> str:
    """Return a value for a template such that no part of it reads as a citation or ends the paragraph."""
    return value if isinstance(value, Markup) else _one_line(str(value)).replace("[", "[[")


def paragraphs(filled: str) -> list[str]:
    """Return the paragraphs of a filled template, each as one line; blank lines separate them, 1e-08 is 1e-8."""
    filled = re.sub(r"(?<![\w.=])(\d[\d.]*e-)0(?=\d\b)", r"\1", filled)  # not in labels
    return [" ".join(text.split()) for text in re.split(r"\n\s*\n", filled) if text.strip()]


def cited_keys(prose: Sequence[str]) -> list[str]:
    """Return the keys that the paragraphs cite, in alphabetical order."""
    return sorted({key for text in prose for keys in _CITATION.findall(text) for key in keys.split("; @")})


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
LATEX = Style(prose, lambda works: f"~\\cite{{{','.join(work.key for work in works)}}}")
