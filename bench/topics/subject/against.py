"""Compare the subject of a study with its rivals: wins, losses and open pairs, as facts and as the first screen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np
import pandas as pd

from bench.analysis.error_rates import Levels
from bench.analysis.subject import OUTCOMES, in_parts, seen_from
from bench.analysis.subject import outcome as outcome_of
from bench.report.parts import Line
from bench.report.prose import speaker
from bench.report.wording import listing
from bench.topics.conditions.differing import Differing, differing
from bench.topics.findings import Findings

TITLE = "Against its rivals"
WORDS = 20  # of a line, at most
NAMED = 2  # rivals that a clause names
PARTS = {"where": TITLE, "by_how_much": TITLE, "how_sure": "How often would this page be wrong?", "at_what_cost": TITLE}
PARTS["conditions"] = "The numbers behind it"


class Rival(NamedTuple):
    """The subject against one rival.

    Attributes:
        label: of the rival.
        outcome: "better", "worse" or "open", by the test over all problems, as seen from the subject.
        chance: that a run of the subject ends lower, in the mean over problems, with its 95% interval, low to high.
        p: of the test over all problems, adjusted over the pairs that are tested; missing where there is none.
        better: the problems on which the subject is separably lower.
        worse: those on which the rival is.
        ratio: the median over problems of the rival's expected running time over that of the subject.
        both: the problems on which both reach the target, over which the median is.
    """

    label: str
    outcome: str
    chance: float
    low: float
    high: float
    p: float
    better: int
    worse: int
    ratio: float
    both: int


@dataclass(frozen=True)
class Against:
    """The facts on the subject, from which its sentences are written.

    Attributes:
        subject: its label.
        rivals: in the order of their places.
        parts: of :func:`bench.analysis.in_parts`.
        levels: of the tests.
        enough: trials a cell from which on single problems are tested; 0 where they are.
        parts_level: of all tests in parts together (:meth:`bench.analysis.Levels.in_parts`).
        pairs: the pairs over which the tests are adjusted.
        declared: whether the first run named the subject, so that its pairs alone are tested.
        problems: on which every optimizer has trials.
        trials: of a cell, in words.
        budget: in words.
        target: to which the running times are, in words.
        unlike: what may explain its wins or losses besides the algorithms.
        selected: whether optimizers or problems were selected after the results were seen.
    """

    subject: str
    rivals: Sequence[Rival]
    parts: pd.DataFrame
    levels: Levels
    enough: int
    parts_level: float
    pairs: int
    declared: bool
    problems: int
    trials: str
    budget: str
    target: str
    unlike: Differing
    selected: bool

    @property
    def named_first(self) -> list[Rival]:
        """The rivals as lines name them: earlier versions, the best that loses and the best that wins, then others."""
        versions = [rival for rival in self.rivals if _name_of(rival.label) == _name_of(self.subject)]
        firsts = [next((each for each in self.rivals if each.outcome == one), None) for one in OUTCOMES[:2]]
        ahead = [*versions, *sorted(filter(None, firsts), key=self.rivals.index)]
        return list(dict.fromkeys([*ahead, *self.rivals]))

    def of(self, outcome: str) -> list[str]:
        """Return the labels of the rivals of an outcome."""
        return [rival.label for rival in self.rivals if rival.outcome == outcome]

    @property
    def testable(self) -> bool:
        """Whether any test can be significant."""
        return bool(self.levels.problems or self.levels.across)

    @cached_property
    def exceptions(self) -> list[tuple[str, str, str]]:
        """Outcomes that tests show in a part of the problems but not over all: outcome, rival and parts in words."""
        whole = {rival.label: rival.outcome for rival in self.rivals}
        shown = self.parts[self.parts["outcome"] != "open"]
        other = shown[shown["outcome"] != shown["rival"].map(whole)]
        grouped = other.groupby(["outcome", "rival", "kind"], sort=False)["part"]
        found: list[tuple[str, str, str]] = []
        for key, parts in sorted(grouped, key=lambda group: -len(group[1])):
            outcome, rival, kind = cast("tuple[str, str, str]", key)
            found.append((outcome, rival, _where(kind, list(parts))))
        return found

    @property
    def clear(self) -> bool:
        """Whether the page claims that the subject beats a rival, under like conditions."""
        return bool(self.of("better")) and not self.unlike.clause and not self.selected


def _name_of(label: str) -> str:
    """Return the label of an optimizer without the number of a version."""
    name, at, number = label.rpartition("@")
    return name if at and number.isdecimal() else label


def _where(kind: str, parts: Sequence[str]) -> str:
    """Return parts of one kind in words, such as ``"in dimension 2 and 5"``, or ``"at 1% and 3% of the budget"``."""
    named = listing(parts, 3)
    if kind == "class":
        return f"on {named if len(parts) == 1 else f'{len(parts)} classes of functions'}"
    return f"at {named} of the budget" if kind == "budget" else f"in {kind} {named}"


def against(findings: Findings) -> Against:
    """Return the facts on the subject of a study."""
    trials, final, subject = findings.trials, findings.final, findings.subject
    complete = [str(label) for label in final.medians.index]
    overall = seen_from(final.overall, subject).set_index("second").to_dict("index")
    pairs = final.pairs[final.pairs["problem"].isin(complete)]
    own = seen_from(pairs.astype({"first": object, "second": object, "lower": object}), subject)
    better, worse = (
        own.loc[own["lower"] == (subject if mine else own["second"]), "second"].value_counts() for mine in (True, False)
    )
    ratios = running_time_ratios(findings)
    rivals = []
    for label in final.ranked:
        if label == subject:
            continue
        row, lower, higher = overall[label], int(better.get(label, 0)), int(worse.get(label, 0))
        outcome = outcome_of(float(row["probability"]), bool(row["significant"]) and final.levels.across > 0)
        if not final.levels.across and max(lower, higher) * 2 > len(complete):
            outcome = "better" if lower > higher else "worse"  # all of the level is spent on problems
        rivals.append(
            Rival(
                label, outcome, float(row["probability"]), float(row["low"]), float(row["high"]),
                float(row["p_holm"]) if final.levels.across else np.nan,
                lower, higher, *ratios.get(label, (np.nan, 0)),
            )
        )  # fmt: skip
    wins_and_losses = [[rival.label for rival in rivals if rival.outcome == one] for one in ("better", "worse")]
    return Against(
        subject, rivals, _parts(findings, complete), final.levels, 0 if final.levels.problems else final.enough,
        _parts_level(findings), final.tested,
        declared=findings.declared, problems=len(complete),
        trials=trials.per_cell_words, budget=findings.budget_words,
        target=findings.anytime.target_set.at(findings.anytime.target_set.level),
        unlike=differing(findings, *wins_and_losses), selected=bool(findings.selection),
    )  # fmt: skip


def _parts(findings: Findings, complete: Sequence[str]) -> pd.DataFrame:
    """Return the subject against each rival by dimension, by class of functions, and at smaller budgets."""
    final, level = findings.final, findings.final.levels.course
    earlier = findings.anytime.earlier_leads(findings.subject, level)  # whose p does not depend on a level
    subjects = 1 if final.subject else len(findings.trials.optimizers)
    return in_parts(
        final.pairs,
        parts_of(findings, complete),
        earlier if level else earlier.head(0),
        findings.subject,
        _parts_level(findings),
        subjects,
    )


def _parts_level(findings: Findings) -> float:
    """Return the level of the tests in parts, to which those over all problems pass theirs where all of them reject."""
    final = findings.final
    opened = (final.tested_overall["p_holm"] <= final.levels.across).all()
    return float(final.levels.in_parts(opened))


def parts_of(findings: Findings, complete: Sequence[str]) -> dict[tuple[str, str], list[str]]:
    """Return the problems of each dimension and class of functions, of two at least, where there are several."""
    if not findings.final.levels.course:
        return {}
    known = findings.trials.known
    kinds = {
        "dimension": {label: f"{size}" for label, size in findings.trials.dimensions.items()},
        "class": {label: str(facts.features["group"]) for label, facts in known.items() if "group" in facts.features},
    }
    parts: dict[tuple[str, str], list[str]] = {}
    for kind, part_of in kinds.items():
        named = {label: part_of[label] for label in complete if label in part_of}
        for part in dict.fromkeys(named.values()) if len(set(named.values())) > 1 else ():
            members = [label for label, of in named.items() if of == part]
            if len(members) > 1:
                parts[kind, part] = members
    return parts


def running_time_ratios(findings: Findings) -> dict[str, tuple[float, int]]:
    """Return the median ratio of each rival's ERT over that of the subject, and of how many problems it is."""
    ert = findings.anytime.ert_at_level
    if findings.subject not in ert:
        return {}
    ratios = ert.div(ert[findings.subject], axis=0)
    return {str(label): (float(ratios[label].median()), int(ratios[label].count())) for label in ratios}


class FirstScreen(NamedTuple):
    """The headline, the lines below the pictures, and the sentences that they shorten."""

    headline: str
    lines: tuple[Line, ...]
    details: tuple[str, ...]


def first_screen(known: Against) -> FirstScreen:
    """Return the headline, the lines and the details of the first screen of a study with a subject."""
    say = speaker(__package__, it=known, NAMED=NAMED)
    texts: dict[str, str] = {
        "where": _short(say, "where", len(known.exceptions)),
        "by_how_much": _short(say, "by_how_much", min(len(known.rivals), 2)),
        "how_sure": say("how_sure"),
        "at_what_cost": _short(say, "at_what_cost", 2),
        "conditions": known.unlike.line,
    }
    lines = [Line(label.replace("_", " "), text, PARTS[label]) for label, text in texts.items() if text]
    details = (say("abstract"), say("named"), say("scope"), say("conditions"))
    return FirstScreen(say("headline"), tuple(lines), tuple(filter(None, details)))


def _short(say: Any, name: str, most: int) -> str:
    """Return a line that names as many items as fit into its words."""
    tries = (str(say(name, number)) for number in range(most, -1, -1))
    return next((text for text in tries if len(text.split()) <= WORDS), "")


def subject_rule(known: Against) -> str:
    """Return when the subject is called better or worse."""
    return speaker(__package__, it=known, NAMED=NAMED)("rule")
