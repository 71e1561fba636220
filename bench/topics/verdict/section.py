"""The verdict: the best optimizer, its lead, the certainty and the budget, with the ranks on every problem."""

from __future__ import annotations

import json
from collections import Counter

import numpy as np

from bench import analysis
from bench.analysis import ALPHA
from bench.analysis.integrity import undeclared
from bench.report.parts import Card, File, Part, Section
from bench.report.prose import speaker
from bench.report.wording import count, listing, percent, unfinished_trials
from bench.storage.folder import ANSWER
from bench.topics.conditions.conditions import sentences
from bench.topics.conditions.differing import UNUSED, differing, shares_used
from bench.topics.findings import Final, Findings
from bench.topics.integrity.section import warnings
from bench.topics.runs.ranks import rank_map
from bench.topics.subject.against import FirstScreen, against, first_screen, subject_rule
from bench.topics.trials.power import error_text
from bench.topics.verdict.across import across
from bench.topics.verdict.answer import answer
from bench.topics.verdict.clock import clock
from bench.topics.verdict.first_picture import evidence
from bench.topics.verdict.winner import TIED, Across, Conclusion, Stage, Standing, verdict, winner_rule

TITLE = "Verdict"
SAY = speaker(__package__)
SEPARABLY = (
    "Separably lower: on a problem, a run of one ends lower than a run of the other more often than not, and a test "
    "shows that."
)


def section(findings: Findings) -> Section:
    """Return the verdict, or a section that states why there is nothing to compare."""
    if findings.trials.whole.empty:
        return Section(TITLE, warnings=("The study has no trial yet, so there is no verdict.",))
    lost, troubles = unfinished_trials(findings.trials.comparable.working), warnings(findings)
    nothing = ""
    if len(findings.final.ranking) < 2:
        nothing = f"There is nothing to compare: {findings.trials.optimizers[0]} is the only optimizer."
    elif not len(findings.final.medians):
        nothing = "There is nothing to compare: no problem has trials of every optimizer that can be compared."
    elif not (findings.trials.frame["status"] == "ok").any():
        nothing = "There is nothing to compare: no trial finished."
    if nothing:
        return Section(TITLE, (nothing,), lost=lost, warnings=troubles)
    said: Conclusion | FirstScreen
    if findings.subject:
        known = findings.of(against)
        said, clear, leads = first_screen(known), known.clear, False
    else:
        found = standing(findings)
        said = verdict(found)
        clear, leads = said.clear, bool(found.leads)
    conditions = sentences(findings.study, findings.descriptions, findings.leader)
    definition = (SEPARABLY,) if any("separably" in line.text for line in said.lines) else ()
    cards = (
        Card("", (said.headline,), "claim" if clear else "open", lines=said.lines),
        Card("The numbers behind it", (*said.details, *definition, _evidence(findings)), "limit", folded=True),
        Card("What may not be claimed", (*_limits(findings), *conditions.limits), "limit", folded=True),
        Card("How often would this page be wrong?", error_text(findings), "limit", folded=True),
        Card("How this is decided", (_grounds(findings), *conditions.others), "limit", folded=True),
    )
    items: list[Part] = [evidence(findings, leads), rank_map(findings)]
    return Section(TITLE, (), tuple(items), troubles, cards=cards, lost=lost)


def standing(findings: Findings) -> Standing:
    """Return the facts from which the verdict is written."""
    trials, final = findings.trials, findings.final
    complete = list(final.medians.index)
    ranking = final.ranking.sort_values("place", kind="stable")
    clear = final.pairs[final.pairs["problem"].isin(complete) & (final.pairs["lower"] != "")]
    beaten: Counter[tuple[str, str]] = Counter()
    for first, second, lower in zip(clear["first"], clear["second"], clear["lower"], strict=True):
        beaten[str(lower), str(second if lower == first else first)] += 1
    all_known = all(label in trials.unbeaten for label in complete)
    best = "the optimum" if all_known else "the best known value"
    return Standing(
        ranking, beaten, _across(final), final.levels,
        budget=findings.budget_words,
        problem=str(complete[0]) if len(complete) == 1 else "",
        trials=trials.per_cell_words,
        unlike=differing(findings, final.ranked[1:]),
        differing=_dimensions(findings),
        left_out=[label for label in trials.problems if label not in complete],
        size=_size(findings),
        near_shares=findings.anytime.near_best,
        near=f"{findings.anytime.near_words} of {best}",
        course=_course(findings),
        unit="of the budget" if trials.scaled else "evaluations",
        clock=clock(findings),
        selected=bool(findings.selection),
    )  # fmt: skip


def _across(final: Final) -> dict[tuple[str, str], Across]:
    """Return each pair over all problems, seen from either side."""
    pair_of, level = {}, final.levels.across
    for pair in final.overall.to_dict("records"):
        first, second = str(pair["first"]), str(pair["second"])
        ends = {name: float(pair[name]) for name in ("probability", "low", "high")}
        chance, low, high = ends.values()
        p, clear = float(pair["p"]), bool(pair["p"] <= level)
        sides = [clear and pair["lower"] == label for label in (first, second)]
        pair_of[first, second] = Across(chance, low, high, p, sides[0])
        pair_of[second, first] = Across(1 - chance, 1 - high, 1 - low, p, sides[1])
    return pair_of


def _dimensions(findings: Findings) -> str:
    """Return in which dimensions of a suite another optimizer has the lowest mean rank; "" where none does."""
    standing = findings.final.standings[findings.final.standings["problem"].isin(list(findings.final.medians.index))]
    dimension = standing["problem"].astype(object).map(findings.trials.dimensions)
    suite = {label for label in findings.trials.suite_functions if label in findings.trials.dimensions}
    if dimension.nunique() < 2 or not set(findings.final.medians.index) <= suite:
        return ""
    leader, others = findings.final.ranked[0], {}
    for in_dimension, rows in standing.groupby(dimension):
        ranks = analysis.mean_ranks(rows)
        lowest = [str(label) for label in ranks.index[np.isclose(ranks, ranks.min(), rtol=0, atol=TIED)]]
        if leader not in lowest:
            others[f"{in_dimension:g}"] = listing(lowest, 2)
    if len(others) > 2:
        return f"not in {len(others)} of {dimension.nunique()} dimensions"
    return f"not in dimension {listing([f'{d} ({names})' for d, names in others.items()])}" if others else ""


def _size(findings: Findings) -> str:
    """Return by how much the first in rank is lower than the second: in evaluations on suites, else in medians."""
    first, second = findings.final.ranked[:2]
    chosen = findings.anytime.target_set
    if chosen.absolute and not findings.anytime.running_times.empty:
        ert = findings.anytime.ert_at_level.reindex(columns=[first, second]).dropna()
        if ert.empty:
            return ""
        factor = _times(float((ert[second] / ert[first]).median()))
        return (
            f"To {chosen.at(chosen.level)}, {second} needs {factor} evaluations (median ratio of expected running "
            f"times over the {count(len(ert), 'problem')} where both reach it)."
        )
    medians = findings.final.medians[[first, second]].replace(np.inf, np.nan).dropna().astype(float)
    medians = medians[medians[first] != 0]
    if medians.empty:
        return ""
    if len(medians) == 1:
        one, other = medians.iloc[0]
        return f"The medians are {one:.4g} and {other:.4g}, {abs(other - one):.3g} apart."
    if not (medians > 0).all(axis=None):
        return ""  # a share of a value at or below zero means nothing
    gain = 100 * (medians[second] - medians[first]) / medians[second]
    low, middle, high = gain.quantile([0.0, 0.5, 1.0])
    which = "lower" if middle >= 0 else "higher"
    return f"Its median is {_figure(middle)}% {which} in the median over problems{_spread(low, high)}."


def _times(ratio: float) -> str:
    """Return a ratio of running times in words."""
    if 0.995 <= ratio < 1.05:
        return "about as many"
    return f"{ratio:.2g} times as many" if ratio >= 1 else f"only {ratio:.0%} as many"


def _figure(percentage: float) -> str:
    """Return a percentage without its sign, in digits alone."""
    return f"{abs(percentage):.2g}" if abs(percentage) < 99.5 else f"{abs(percentage):,.0f}"


def _spread(low: float, high: float) -> str:
    """Return in brackets how much lower, in percent, a median is on the problem with the least gain and the most."""
    ends = [f"{_figure(end)}%" for end in (low, high)]
    if ends[0] == ends[1] and low * high >= 0:
        return ""
    if low < 0 < high:
        return f" ({ends[0]} higher to {ends[1]} lower)"
    return f" ({ends[0]} to {ends[1]} lower)" if low >= 0 else f" ({ends[1]} to {ends[0]} higher)"


def _course(findings: Findings) -> list[Stage]:
    """Return the optimizers shown to be lower than the leader at the budgets of the figure beside the verdict."""
    if not findings.trials.traces:
        return []
    leader = findings.final.ranked[0]
    leads = findings.anytime.earlier_leads(leader, findings.final.levels.course)
    shown = leads[leads["shown"].astype(bool)].groupby("share")["optimizer"].agg(tuple).to_dict()
    spent = findings.anytime.stages.drop_duplicates("share")
    if len(spent) < 2:
        return []  # nothing is known of smaller budgets
    return [
        Stage(f"{share:.0%}" if findings.trials.scaled else f"{evaluations:,}", shown.get(share, (leader,)))
        for share, evaluations in zip(spent["share"], spent["evaluations"], strict=True)
    ]


def _evidence(findings: Findings) -> str:
    """Return on how much evidence the verdict rests."""
    working = findings.trials.comparable.working
    failed = working.loc[working["status"] != "ok", "optimizer"].astype(str).value_counts(sort=False)
    return SAY(
        "evidence",
        findings.trials.per_cell_words,
        findings.study.budget_words,
        len(findings.final.medians),
        ALPHA,
        findings.final.levels,
        _untested(findings.final),
        findings.subject,
        [f"{count(number, 'trial')} of {label}" for label, number in failed.items()],
    )


def _limits(findings: Findings) -> tuple[str, ...]:
    """Return the sentences on what may not be claimed."""
    trials = findings.trials
    left = 1 - findings.of(shares_used)["needed"]
    left = left[left > UNUSED].sort_values(ascending=False, kind="stable")
    unused = [f"{label} {percent(share)}" for label, share in left.items()]
    texts = (
        SAY("selected", findings.selection) if findings.selection else "",
        SAY("unequal_budgets", trials.common_words) if trials.common else "",
        SAY("counts", len(findings.final.medians)),
        across(findings),
        *_extensions(findings),
        SAY("unused", unused) if unused else "",
    )
    return tuple(filter(None, texts))


def _extensions(findings: Findings) -> list[str]:
    """Return the sentences on trials added to complete ones; none where there were none."""
    return [
        f"Optional stopping: {held:,} trials of each cell were complete, and could be looked at, when {asked:,} were "
        "asked for. If the results were a reason for that, the p-values are too small and the tests err more often "
        "than alpha says."
        for held, asked in undeclared(findings.trials.extensions)
    ]


def _grounds(findings: Findings) -> str:
    """Return by which tests and levels the verdict is decided."""
    final = findings.final
    trials = findings.trials.per_cell[0]
    rule = subject_rule(findings.of(against)) if findings.subject else winner_rule()
    subject, untested = findings.subject, _untested(final)
    return SAY("grounds", final.levels, final.tests, final.tested, trials, ALPHA, rule, subject, untested)


def _untested(final: Final) -> str:
    """Return the level of tests on problems and the trials that they need; "" where they are made."""
    return "" if final.levels.problems else SAY("untested", final.level_on_problems, final.enough)


def answer_file(findings: Findings) -> list[File]:
    """Return the answer in a few lines, which 'bench run' and 'bench status' print."""
    lines = answer(findings, findings.of(section))
    return [File(ANSWER, "The answer in a few lines, as JSON.", json.dumps(lines, ensure_ascii=False, indent=1))]
