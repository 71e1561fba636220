"""The methods section of a paper about a study: sentences that are true of the actual run, and the works they cite."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.analysis import ALPHA
from bench.analysis.cells import NEAR
from bench.analysis.pairwise import RESAMPLES, TIED
from bench.bibtex import Work, parse
from bench.errors import BenchError
from bench.report.prose import LATEX, MARKDOWN, TEXT, Cite, Sentence, keys, say, series
from bench.report.references import library, united
from bench.report.wording import count, listing, options
from bench.study import Entry, Study

BIBLIOGRAPHY = "references.bib"
"""What the file of the cited works is called beside the methods."""

NEUTRAL = ("joblib", "matplotlib", "pandas", "seaborn")
"""Packages on which no trial's result depends: they schedule trials, keep tables and draw."""

SCALES = {
    "log10 error": "the logarithms of the medians’ distances from the known optima",
    "log10 median": "the logarithms of the medians",
    "share of range": "the medians, scaled to the range of the medians on their problem",
}
"""What the paired tests across problems compare, by the names of :func:`bench.analysis.across.relative_medians`."""

CENTRE_BIAS = "a bias to the centre of the search space [@kudela2022]"
STRUCTURAL_BIAS = (
    "structural bias, a preference for parts of the search space that shows on pure noise [@kononova2015; "
    "@vermetten2022]"
)
"""What optimizers are probed for."""


@dataclass(frozen=True)
class MethodsFacts:
    """What a methods section must know of a run.

    Attributes:
        study: what was planned.
        trials: the fewest and the most trials of a cell (problem and optimizer), of those that have any.
        empty: cells without any trial.
        failed: trials that failed, of all.
        bibtex: each optimizer's BibTeX by label; an optimizer without any is not cited.
        environments: what each run noted of itself and its machine (:mod:`bench.storage.provenance`).
        tests: pairs of optimizers compared by a test, over all problems.
        permutation_tests: those of them whose p is that of the permutation distribution given the ties.
        alpha: the significance level.
        ranked_problems: problems that entered the comparison across problems.
        scale: what the paired tests across problems compare, one of ``SCALES``.
        known_optima: problems whose optimum is known.
        targets: problems that have targets.
        early: trials that stopped by a criterion of their own before their budget was spent, by optimizer.
        centre_bias: which optimizers were probed for a bias to the centre of the box, and whether they have it.
        structural_bias: the same of a preference for parts of the box on pure noise.
    """

    study: Study
    trials: tuple[int, int]
    empty: int = 0
    failed: int = 0
    bibtex: Mapping[str, str] = field(default_factory=dict)
    environments: Sequence[Mapping[str, Any]] = ()
    tests: int = 0
    permutation_tests: int = 0
    alpha: float = ALPHA
    ranked_problems: int = 0
    scale: str = "log10 median"
    known_optima: int = 0
    targets: int = 0
    early: Mapping[str, int] = field(default_factory=dict)
    centre_bias: Mapping[str, bool] = field(default_factory=dict)
    structural_bias: Mapping[str, bool] = field(default_factory=dict)


@dataclass(frozen=True)
class Methods:
    """The same sentences three ways.

    Attributes:
        text: plain paragraphs, which cite by author and year.
        markdown: with citations and front matter as pandoc reads them.
        latex: paragraphs to be read with ``\\input``.
        bibtex: the works cited, in the order of their keys.
        warnings: optimizers whose BibTeX cannot be read, and why; they are not cited.
    """

    text: tuple[str, ...]
    markdown: str
    latex: str
    bibtex: str
    warnings: tuple[str, ...]


def methods(facts: MethodsFacts) -> Methods:
    """Return the methods section of a run; every sentence in it is true of that run."""
    works, own, warnings = _bibliography(facts)
    parts = (_experiment(facts, own), _each_problem(facts), [*_across_problems(facts), *_targets(facts)])
    paragraphs = [paragraph for part in parts if (paragraph := list(part))]
    title = json.dumps(MARKDOWN.plain(f"Methods: {facts.study.title or facts.study.name}"), ensure_ascii=False)
    front = f"---\ntitle: {title}\nbibliography: {BIBLIOGRAPHY}\n---"
    comment = f"% {BIBLIOGRAPHY} has the works cited"
    return Methods(
        text=tuple(TEXT.write(paragraph, works) for paragraph in paragraphs),
        markdown="\n\n".join([front, *(MARKDOWN.write(paragraph, works) for paragraph in paragraphs)]) + "\n",
        latex="\n\n".join([comment, *(LATEX.write(paragraph, works) for paragraph in paragraphs)]) + "\n",
        bibtex="\n".join(works[key].bibtex + "\n" for key in keys(paragraphs)),
        warnings=warnings,
    )


# what is said


def _experiment(facts: MethodsFacts, own: Mapping[str, tuple[str, ...]]) -> Iterator[Sentence]:
    """Say what was run on what, how often and with which software."""
    study = facts.study
    several = len(study.optimizers) > 1
    labels = [entry.label for entry in study.problems]
    yield say(
        "We compared {number} on {problems}: {optimizers}." if several else "We ran {optimizers} on {problems}.",
        number=count(len(study.optimizers), "optimizer"),
        problems=f"{count(len(labels), 'problem')} ({listing(labels, at_most=20)})",
        optimizers=series([[_name(entry), Cite(own[entry.label])] for entry in study.optimizers]),
    )
    alike: dict[str, list[str]] = {}
    for entry in study.optimizers:
        alike.setdefault(options(entry.options), []).append(entry.label)
    if alike.keys() != {""}:
        given = [f"{listing(names, at_most=len(names))} with {text}" for text, names in alike.items() if text]
        yield say("We ran {given}; all other parameters have their default values.", given="; ".join(given))
    else:
        yield say("All parameters have their default values.")
    fewest, most = facts.trials
    yield say(
        "{who} made {trials}{planned}{where}; a trial could spend {budget} of the objective function.",
        who="Each optimizer" if several else "It",
        trials=count(most, "independent trial") if fewest == most else f"{fewest:,} to {most:,} independent trials",
        planned="" if fewest == most == study.trials else f" of {study.trials:,} planned",
        where=" on each problem" if len(labels) > 1 else "",
        budget=count(study.budget, "evaluation"),
    )
    if facts.empty:
        yield say("{cells} of problem and optimizer had no trial.", cells=count(facts.empty, "pair"))
    if early := {label: number for label, number in facts.early.items() if number}:
        yield say(
            "Not all of it was spent: {stopped} stopped by criteria of their own.",
            stopped=listing([f"{count(number, 'trial')} of {label}" for label, number in early.items()]),
        )
    yield say("The score of a trial is the lowest objective value that it found.")
    if facts.failed:
        yield say(
            "{failed} failed or found no finite value; they score worse than any other, and we leave none out.",
            failed=count(facts.failed, "trial"),
        )
    yield say(
        "Every trial draws its random numbers from a stream of its own, which the study’s seed ({seed}), the problem, "
        "the optimizer and the trial’s number determine.",
        seed=str(study.seed),
    )
    for probed, what in ((facts.centre_bias, CENTRE_BIAS), (facts.structural_bias, STRUCTURAL_BIAS)):
        if probed:
            biased = [label for label, found in probed.items() if found]
            yield say(
                f"We probed {{which}} for {what}: {{found}}.",
                which="the optimizers" if len(probed) == len(study.optimizers) else listing([*probed]),
                found=f"{listing(biased)} {'has' if len(biased) == 1 else 'have'} it" if biased else "none has it",
            )
    yield from _software(facts.environments)


def _software(environments: Sequence[Mapping[str, Any]]) -> Iterator[Sentence]:
    """Say which software ran on which machine, as far as it was noted."""
    versions: dict[str, list[str]] = {}
    for environment in environments:
        for name, version in {"Python": environment.get("python"), **(environment.get("packages") or {})}.items():
            if version and name not in NEUTRAL:
                versions[name] = _distinct([*versions.get(name, []), str(version)])
    if not versions:
        return
    works = {"numpy": [Cite(("harris2020",))], "scipy": [Cite(("virtanen2020",))]}
    packages: list[Sentence] = [
        [f"{name} {' and '.join(found)}", *works.get(name, [])] for name, found in versions.items()
    ]
    processors = _distinct(environment.get("processor") for environment in environments)
    states: dict[str, list[Mapping[str, Any]]] = {}
    for environment in environments:
        for name, git in {"source code": environment.get("git"), **(environment.get("checkouts") or {})}.items():
            states.setdefault(name, []).extend([git] if git else [])
    code = [text for name, found in states.items() if (text := _commits(name, found))]
    yield say(
        "The trials used {packages}{source}{machine}.",
        packages=series(packages),
        source=f" ({'; '.join(code)})" if code else "",
        machine=f" on {listing(processors)}" if processors else "",
    )


def _commits(name: str, states: Sequence[Mapping[str, Any]]) -> str:
    """Return the commits of a checkout, "" where none is known."""
    commits = _distinct(str(state.get("commit") or "")[:10] for state in states)
    changed = ", with local changes" if any(state.get("dirty") for state in states) else ""
    return f"{name} at commit {listing(commits)}{changed}" if commits else ""


def _each_problem(facts: MethodsFacts) -> Iterator[Sentence]:
    """Say how pairs of optimizers are compared on one problem."""
    if not facts.tests:
        return
    several, pairs = len(facts.study.problems) > 1, len(facts.study.optimizers) > 2
    tests, level = count(facts.tests, "test"), f"{facts.alpha:g}"
    yield say(
        "{where} compare {who} by the two-sample Kolmogorov–Smirnov test with its exact p-value [@hodges1958]; "
        "values that agree to a relative {near} count as equal.",
        where="On each problem we" if several else "We",
        who="every pair of optimizers" if pairs else "the two optimizers",
        near=f"{NEAR:g}",
    )
    if facts.permutation_tests:
        yield say(
            "In {some} of {tests}, where more than {tied} of the values are tied, it is the p-value of the permutation "
            "distribution given the ties, also exact [@schroer1995].",
            some=f"{facts.permutation_tests:,}",
            tests=tests,
            tied=f"{TIED:.0%}",
        )
    if pairs:
        yield say(
            "Holm’s method [@holm1979] keeps the chance of any false positive{where} at {level} or below, and "
            "optimizers that share a letter do not differ significantly [@piepho2004].",
            where=" on a problem" if several else "",
            level=level,
        )
    if several:
        yield say(
            "For claims about the whole study, the Benjamini–Yekutieli procedure [@benjamini2001] keeps the rate of "
            "false discoveries among all {tests} at {level} or below.",
            tests=tests,
            level=level,
        )
    yield say(
        "As effect sizes we report A12, the chance that a trial of one optimizer ends lower than a trial of the other, "
        "ties counted half [@vargha2000], with 95 % percentile intervals from a bootstrap of {resamples} resamples "
        "[@efron1979], and Cliff’s delta, which is 2 A12 − 1 [@cliff1993], beside the Mann–Whitney test [@mann1947]; "
        "an optimizer is called the lower one only where that interval leaves out 0.5.",
        resamples=f"{RESAMPLES:,}",
    )


def _across_problems(facts: MethodsFacts) -> Iterator[Sentence]:
    """Say how optimizers are compared over all problems."""
    optimizers, problems, ranked = len(facts.study.optimizers), len(facts.study.problems), facts.ranked_problems
    if optimizers < 2 or ranked < 2:
        return
    yield say(
        "Across problems{only} the unit is the problem, and its value the median of its trials.",
        only="" if ranked == problems else f" ({ranked:,} of {problems:,}, on which every optimizer has a trial)",
    )
    if optimizers > 2:
        yield say(
            "We compare the average ranks of the optimizers by Friedman’s test [@friedman1937] with the correction of "
            "Iman and Davenport [@iman1980], and draw them with the critical difference of Nemenyi’s test "
            "[@nemenyi1963; @demsar2006]."
        )
    yield say(
        "{who} we compare by Wilcoxon’s signed-rank test [@wilcoxon1945] on {scale}{adjusted}.",
        who="Pairs of optimizers" if optimizers > 2 else "The two optimizers",
        scale=SCALES[facts.scale],
        adjusted=", adjusted by Holm’s method" if optimizers > 2 else "",
    )
    yield say(
        "The probability of improvement and the interquartile mean of the normalised errors sum up all trials, with "
        "95 % intervals from a bootstrap stratified by problem and optimizer [@agarwal2021]."
    )


def _targets(facts: MethodsFacts) -> Iterator[Sentence]:
    """Say how progress over the evaluations is measured."""
    if not facts.targets:
        return
    known, found = "the known optimum", "the lowest value that any trial found"
    if 0 < facts.known_optima < facts.targets:
        reference = f"{known} on {count(facts.known_optima, 'problem')} and to {found} on the others"
    else:
        reference = known if facts.known_optima else found
    yield say(
        "We measure progress by targets that divide the way from a trial’s typical first value to {reference} "
        "[@more2009].",
        reference=reference,
    )
    yield say(
        "We report the expected running time to a target and the empirical distribution of running times [@hansen2016; "
        "@hansen2021], data profiles [@more2009], and success rates with Wilson’s 95 % intervals [@wilson1927]."
    )


# the parts of a sentence


def _bibliography(facts: MethodsFacts) -> tuple[dict[str, Work], dict[str, tuple[str, ...]], tuple[str, ...]]:
    """Return all works by key, each optimizer's keys by label, and what could not be read."""
    works, own, warnings = list(library().values()), {}, []
    for entry in facts.study.optimizers:
        try:
            references = parse(facts.bibtex.get(entry.label, ""))
        except BenchError as error:
            references = []
            warnings.append(f"{entry.label} is not cited: {error}.")
        works, named = united(works, references)
        own[entry.label] = tuple(reference.key for reference in named)
    return {reference.key: reference for reference in works}, own, tuple(warnings)


def _name(entry: Entry) -> str:
    return entry.label if entry.label == entry.name else f"{entry.label} (the optimizer {entry.name})"


def _distinct(values: Iterable[Any]) -> list[str]:
    return list(dict.fromkeys(value for value in values if value))
