"""The first section of the page: who ends lowest, where, by how much, how sure that is, and at what cost."""

from __future__ import annotations

from math import inf, isnan

from bench.report.parts import Card, Line, Section
from bench.topics.answer import words
from bench.topics.answer.changes import changes
from bench.topics.answer.facts import elsewhere, facts, on_problems, own_seconds, ratios
from bench.topics.answer.figures import chance_figure
from bench.topics.findings import Findings
from bench.topics.runs.ranks import rank_map

TITLE = "Answer"


def section(findings: Findings) -> Section:
    """Return the answer, or a section that states why there is nothing to compare."""
    if nothing := nothing_to_compare(findings):
        return Section(TITLE, (nothing,))
    known = findings.of(facts)
    shown = bool(known.of("better")) if known.is_subject else known.wins
    clear = shown and not known.unlike and not findings.of(changes).made
    card = Card(headline(findings), "claim" if clear else "open")
    return Section(TITLE, items=(chance_figure(known), rank_map(findings)), cards=(card,), lines=lines(findings))


def nothing_to_compare(findings: Findings) -> str:
    """Return why nothing can be compared; "" where something can."""
    if findings.trials.whole.empty:
        return "The study has no trial yet."
    if len(findings.trials.optimizers) < 2:
        return f"There is nothing to compare: {findings.trials.optimizers[0]} is the only optimizer."
    if not len(findings.final.medians):
        return "There is nothing to compare: no problem has trials of every optimizer that can be compared."
    if not (findings.trials.frame["status"] == "ok").any():
        return "There is nothing to compare: no trial finished."
    return ""


def headline(findings: Findings) -> str:
    """Return the sentence that a page, a terminal and a notebook begin with."""
    known = findings.of(facts)
    if known.is_subject:
        return words.against(known.chosen, known.of("better"), known.of("worse"), known.of("open"), known.problems)
    if known.wins:
        return words.winner(known.chosen, known.problems, bool(known.unlike))
    return words.no_winner(known.first, known.not_beaten, known.problems, known.tested)


def lines(findings: Findings) -> tuple[Line, ...]:
    """Return the lines below the headline: where, by how much, how sure and at what cost."""
    if nothing_to_compare(findings):
        return ()
    texts = {
        "where": (_where(findings), "Every run"),
        "by how much": (_by_how_much(findings), "Over the budget"),
        "how sure": (_how_sure(findings), "Can you trust it?"),
        "at what cost": (_cost(findings), "Cost"),
    }
    return tuple(Line(label, text, part) for label, (text, part) in texts.items() if text)


def _where(findings: Findings) -> str:
    known, outcomes = findings.of(facts), on_problems(findings)
    if len(known.problems) == 1:
        return ""
    first = findings.final.order.set_index("optimizer")["first"].to_dict()
    parts = [words.first_on(int(first[known.chosen]), len(known.problems))]
    if not known.tested:
        return parts[0]
    if known.is_subject:
        for rival in known.named["rival"]:
            own = outcomes[rival]
            if (own != "open").any():
                parts.append(words.lower_than(rival, int((own == "better").sum()), int((own == "worse").sum())))
    else:
        if lowest := int((outcomes == "better").all(axis=1).sum()):
            parts.append(words.lower_than_all(lowest))
        if other := elsewhere(findings):
            parts.append(words.not_in(other))
    return "; ".join(parts)


def _by_how_much(findings: Findings) -> str:
    known, table = findings.of(facts), findings.of(ratios)
    if len(table):
        chosen = findings.anytime.target_set
        closed = (table["low"] > 0) & (table["high"] < inf)  # an open interval that holds 1 says nothing
        rows = table[table["rival"].isin(known.named["rival"]) & (closed | (table["low"] > 1) | (table["high"] < 1))]
        if len(rows):
            ends = rows[["rival", "ratio", "low", "high"]].itertuples(index=False, name=None)
            return words.as_many(chosen.at(chosen.level), list(ends))
    row = known.named.iloc[0]
    second = not known.is_subject and len(known.rivals) > 1
    chance, low, high = (float(row[name]) for name in ("chance", "low", "high"))
    return "" if isnan(low) else words.chance(known.chosen, str(row["rival"]), chance, low, high, second)


def _how_sure(findings: Findings) -> str:
    known, found = findings.of(facts), findings.of(changes)
    if not known.tested:
        return words.chance_order()
    if found.made:
        return words.changed(found.made, findings.study.seed + 1)
    sure = words.sure(known.is_subject, len(known.problems))
    return sure if found.known else f"{sure}; {words.not_known()}"


def _cost(findings: Findings) -> str:
    known, own = findings.of(facts), own_seconds(findings)
    rival = str(known.named["rival"].iloc[0])
    if known.chosen not in own or rival not in own:
        return ""
    return words.own_time(known.chosen, float(own[known.chosen]), rival, float(own[rival]))
