"""The methods section of a paper about a study: sentences that hold for the actual run, and the works they cite."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bench.analysis import ALPHA
from bench.analysis.cells import NEAR
from bench.analysis.pairwise import RESAMPLES, TIED
from bench.bibtex import Work, parse
from bench.errors import BenchError
from bench.report.prose import LATEX, MARKDOWN, TEXT, Cite, Sentence, cited_keys, sentence, series
from bench.report.references import library, merge_works
from bench.report.software import software
from bench.report.wording import count, listing, options
from bench.study import Entry, Study

BIBLIOGRAPHY = "references.bib"  # the file of the cited works, beside the methods

SCALES = {
    "log10 error": "the logarithms of the medians’ distances from the known optima",
    "log10 median": "the logarithms of the medians",
    "share of range": "the medians scaled to the range of the medians on each problem",
}
"""What the paired tests across problems compare, by the names of :func:`bench.analysis.across.relative_medians`."""

CENTRE_BIAS = "a bias towards the centre of the search space [@kudela2022]"
STRUCTURAL_BIAS = (
    "structural bias, a preference for parts of the search space that shows on pure noise [@kononova2015; "
    "@vermetten2022],"
)
"""The traits that optimizers are tested for."""


@dataclass(frozen=True)
class MethodsFacts:
    """The facts about a run that its methods section states.

    Attributes:
        study: the study as planned.
        trials: the fewest and the most trials of a cell (problem and optimizer), of those that have any.
        empty: cells without any trial.
        failed: trials that failed, of all.
        bibtex: each optimizer's BibTeX by label; an optimizer without any is not cited.
        environments: what each run recorded of itself and its machine (:mod:`bench.storage.provenance`).
        tests: pairs of optimizers compared by a test, over all problems.
        permutation_tests: those of them that use the permutation distribution given the ties.
        alpha: the significance level.
        ranked_problems: problems that entered the comparison across problems.
        scale: what the paired tests across problems compare, one of ``SCALES``.
        known_optima: problems whose optimum is known.
        targets: problems that have targets.
        early: trials that stopped by a criterion of their own before their budget was spent, by optimizer.
        centre_bias: whether each tested optimizer has a bias towards the centre of the box, by label.
        structural_bias: likewise for a preference for parts of the box on pure noise.
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
    parts = (_experiment(facts, own), _each_problem(facts), [*_across_problems(facts), *_targets(facts)])
    paragraphs = [paragraph for part in parts if (paragraph := list(part))]
    title = json.dumps(MARKDOWN.plain(f"Methods: {facts.study.title or facts.study.name}"), ensure_ascii=False)
    front = f"---\ntitle: {title}\nbibliography: {BIBLIOGRAPHY}\n---"
    comment = f"% {BIBLIOGRAPHY} has the works cited"
    return Methods(
        text=tuple(TEXT.write(paragraph, works) for paragraph in paragraphs),
        markdown="\n\n".join([front, *(MARKDOWN.write(paragraph, works) for paragraph in paragraphs)]) + "\n",
        latex="\n\n".join([comment, *(LATEX.write(paragraph, works) for paragraph in paragraphs)]) + "\n",
        bibtex="\n".join(works[key].bibtex + "\n" for key in cited_keys(paragraphs)),
        warnings=warnings,
    )


def _experiment(facts: MethodsFacts, own: Mapping[str, tuple[str, ...]]) -> Iterator[Sentence]:
    """Yield the sentences on what was run on what, how often and with which software."""
    study = facts.study
    several = len(study.optimizers) > 1
    labels = [entry.label for entry in study.problems]
    yield sentence(
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
        yield sentence("We ran {given}; all other parameters have their default values.", given="; ".join(given))
    else:
        yield sentence("All parameters have their default values.")
    fewest, most = facts.trials
    yield sentence(
        "We ran {trials}{planned}{optimizer}{problem}, {each}with a budget of {budget} of the objective function.",
        trials=count(most, "independent trial") if fewest == most else f"{fewest:,} to {most:,} independent trials",
        planned="" if fewest == most == study.trials else f" (of {study.trials:,} planned)",
        optimizer=" of each optimizer" if several else "",
        problem=" on each problem" if len(labels) > 1 else "",
        each="" if most == 1 and not several and len(labels) == 1 else "each ",
        budget=count(study.budget, "evaluation"),
    )
    if facts.empty:
        yield sentence("{cells} of problem and optimizer had no trial.", cells=count(facts.empty, "combination"))
    if early := {label: number for label, number in facts.early.items() if number}:
        yield sentence(
            "{stopped} met a stopping criterion of the optimizer before the budget was spent.",
            stopped=listing([f"{count(number, 'trial')} of {label}" for label, number in early.items()]),
        )
    yield sentence("The score of a trial is the lowest objective value that it found.")
    if facts.failed:
        yield sentence(
            "{failed} failed or found no finite value; such trials are included and score worse than any other.",
            failed=count(facts.failed, "trial"),
        )
    yield sentence(
        "Every trial draws its random numbers from a separate stream, determined by the seed of the study ({seed}), "
        "the problem, the optimizer and the number of the trial.",
        seed=str(study.seed),
    )
    for tested, trait in ((facts.centre_bias, CENTRE_BIAS), (facts.structural_bias, STRUCTURAL_BIAS)):
        if tested:
            biased = [label for label, found in tested.items() if found]
            yield sentence(
                f"We tested {{which}} for {trait} and found it in {{biased}}.",
                which="the optimizers" if len(tested) == len(study.optimizers) else listing([*tested]),
                biased=listing(biased) if biased else "none of them",
            )
    yield from software(facts.environments)


def _each_problem(facts: MethodsFacts) -> Iterator[Sentence]:
    """Yield the sentences on how pairs of optimizers are compared on one problem."""
    if not facts.tests:
        return
    several, pairs = len(facts.study.problems) > 1, len(facts.study.optimizers) > 2
    tests, level = count(facts.tests, "test"), f"{facts.alpha:g}"
    yield sentence(
        "{where} compare {who} by the two-sample Kolmogorov–Smirnov test with its exact p-value [@hodges1958]; "
        "values within a relative difference of {near} count as equal.",
        where="On each problem we" if several else "We",
        who="every pair of optimizers" if pairs else "the two optimizers",
        near=f"{NEAR:g}",
    )
    if facts.permutation_tests:
        yield sentence(
            "In {some} of {tests}, where more than {tied} of the values are tied, we use the exact permutation "
            "distribution given the ties instead [@schroer1995].",
            some=f"{facts.permutation_tests:,}",
            tests=tests,
            tied=f"{TIED:.0%}",
        )
    if pairs:
        yield sentence(
            "Holm’s method [@holm1979] controls the family-wise error rate{where} at {level}; optimizers that share a "
            "letter do not differ significantly [@piepho2004].",
            where=" on each problem" if several else "",
            level=level,
        )
    if several:
        yield sentence(
            "For claims about the whole study, the Benjamini–Yekutieli procedure [@benjamini2001] controls the false "
            "discovery rate over all {tests} at {level}.",
            tests=tests,
            level=level,
        )
    yield sentence(
        "As effect sizes we report A12, the probability that a trial of one optimizer ends lower than a trial of the "
        "other, ties counted half [@vargha2000], with 95 % percentile intervals from {resamples} bootstrap resamples "
        "[@efron1979], and Cliff’s delta, 2 A12 − 1 [@cliff1993], with the Mann–Whitney test [@mann1947].",
        resamples=f"{RESAMPLES:,}",
    )
    yield sentence("We state that an optimizer tends to lower values only where the interval of A12 excludes 0.5.")


def _across_problems(facts: MethodsFacts) -> Iterator[Sentence]:
    """Yield the sentences on how optimizers are compared across problems."""
    optimizers, problems, ranked = len(facts.study.optimizers), len(facts.study.problems), facts.ranked_problems
    if optimizers < 2 or ranked < 2:
        return
    yield sentence(
        "Across problems{only} the unit of analysis is the problem; its value for an optimizer is the median score.",
        only="" if ranked == problems else f" ({ranked:,} of {problems:,}, on which every optimizer has a trial)",
    )
    if optimizers > 2:
        yield sentence(
            "We compare the average ranks of the optimizers by Friedman’s test [@friedman1937] with the correction of "
            "Iman and Davenport [@iman1980], and show them with the critical difference of Nemenyi’s test "
            "[@nemenyi1963; @demsar2006]."
        )
    yield sentence(
        "We compare {who} by Wilcoxon’s signed-rank test [@wilcoxon1945] on {scale}{adjusted}.",
        who="pairs of optimizers" if optimizers > 2 else "the two optimizers",
        scale=SCALES[facts.scale],
        adjusted=", with p-values adjusted by Holm’s method" if optimizers > 2 else "",
    )
    yield sentence(
        "The probability of improvement and the interquartile mean of the normalised errors summarise all trials, with "
        "95 % intervals from a bootstrap stratified by problem and optimizer [@agarwal2021]."
    )


def _targets(facts: MethodsFacts) -> Iterator[Sentence]:
    """Yield the sentences on how progress over the evaluations is measured."""
    if not facts.targets:
        return
    known, found = "the known optimum", "the lowest value that any trial found"
    if 0 < facts.known_optima < facts.targets:
        reference = f"{known} on {count(facts.known_optima, 'problem')} and {found} on the others"
    else:
        reference = known if facts.known_optima else found
    yield sentence(
        "We measure progress by targets between the median first value of the trials and {reference} [@more2009].",
        reference=reference,
    )
    yield sentence(
        "We report the expected running time to a target and the empirical distribution of running times [@hansen2016; "
        "@hansen2021], data profiles [@more2009], and success rates with Wilson’s 95 % intervals [@wilson1927]."
    )


def _bibliography(facts: MethodsFacts) -> tuple[dict[str, Work], dict[str, tuple[str, ...]], tuple[str, ...]]:
    """Return all works by key, the keys of each optimizer's works by label, and warnings."""
    works, own, warnings = list(library().values()), {}, []
    for entry in facts.study.optimizers:
        try:
            references = parse(facts.bibtex.get(entry.label, ""))
        except BenchError as error:
            references = []
            warnings.append(f"{entry.label} is not cited: {error}.")
        works, named = merge_works(works, references)
        own[entry.label] = tuple(reference.key for reference in named)
    return {reference.key: reference for reference in works}, own, tuple(warnings)


def _name(entry: Entry) -> str:
    return entry.label if entry.label == entry.name else f"{entry.label} (the optimizer {entry.name})"
