"""The subject of a study against each of its rivals: one sentence for an abstract, one table, and where it differs."""

from __future__ import annotations

from math import isnan

import pandas as pd

from bench.report.parts import Section, Table
from bench.report.prose import speaker
from bench.topics.findings import Findings
from bench.topics.subject.against import TITLE, Against, against

SAY = speaker(__package__)
WIDER = {"better": "good", "worse": "bad", "open": ""}


def section(findings: Findings) -> Section | None:
    """Return the subject against each rival; None without a subject, and where nothing can be compared."""
    if not findings.subject or len(findings.trials.optimizers) < 2 or not len(findings.final.medians):
        return None
    known = findings.of(against)
    say = speaker(__package__, it=known, NAMED=2)
    items = [_against(known)]
    if len(known.parts):
        items.append(_where(known))
    return Section(TITLE, tuple(filter(None, (say("abstract"), say("named"), say("rule")))), tuple(items))


def _against(known: Against) -> Table:
    data = pd.DataFrame([rival._asdict() for rival in known.rivals])
    opens = known.problems - data["better"] - data["worse"]
    ends = data.set_index("label")
    shown = pd.DataFrame(
        {
            "outcome": data["outcome"],
            "probability": data["chance"],
            "95%": ["–" if isnan(row.low) else f"[{row.low:.2f}, {row.high:.2f}]" for row in known.rivals],
            "p": data["p"],
            "better / worse / open": [
                "not tested" if known.enough else f"{row.better} / {row.worse} / {left}"
                for row, left in zip(known.rivals, opens, strict=True)
            ],
            "ERT ratio": [f"{row.ratio:.3g} ({row.both})" if row.both else "–" for row in known.rivals],
        }
    ).set_index(pd.Index(data["label"], name=f"{known.subject} against"))
    tones = pd.DataFrame({"outcome": [WIDER[each] for each in data["outcome"]]}, index=shown.index)
    return Table(
        "against-rivals",
        f"{known.subject} against each rival, best rival first.",
        shown,
        decimals={"probability": 2},
        tones=tones,
        note=f"Probability: that a run of {known.subject} ends lower, in the mean over problems; p: that this is 0.5, "
        f"adjusted by Holm’s method. Better / worse / open: problems on which {known.subject} is separably lower, "
        f"higher, neither{f'; they are tested from {known.enough} trials a cell on' if known.enough else ''}. "
        f"ERT ratio: the median of the rival’s expected running time to {known.target} over that of {known.subject}, "
        f"in brackets the problems on which both reach it; above 1, {known.subject} is faster.",
        data=ends.reset_index().assign(open=opens),
    )


def _where(known: Against) -> Table:
    """Return the outcome in each part, a row a part and a column a rival."""
    table, rivals = known.parts, [rival.label for rival in known.rivals]
    keys = ["kind", "part"]
    sign = table["outcome"].map({"better": " +", "worse": " −", "open": ""})
    texts = [f"{chance:.2f}{mark}" for chance, mark in zip(table["probability"], sign, strict=True)]
    wide = table.assign(text=texts).pivot(index=keys, columns="rival", values="text")
    order = pd.MultiIndex.from_frame(table[keys].drop_duplicates())
    wide = wide.reindex(index=order, columns=rivals).rename_axis(columns=None)
    return Table(
        "against-rivals-in-parts",
        f"The probability that a run of {known.subject} ends lower in parts of the problems and at smaller budgets.",
        wide,
        note=f"+: shown to be better, −: to be worse, at {known.parts_level:g} for all of this table together, by "
        f"Holm’s method. Classes and dimensions of two problems at least.",
        data=table,
    )
