"""The thesis's views of a study: Table 7.2, Figs. 7.3 to 7.5 and the best fit, in the section "In your units"."""

import pandas as pd

from bench.analysis import in_study_order
from bench.report import Line, Part, Section, Table, listing
from bench.topics import Findings
from problems.backlash.report import figures, fitting_errors, reference, words
from problems.backlash.report.accuracy import estimates, expected_values

TITLE = "In your units"
FIGURES = ("amplitude_rpm", "backlash_rad")


def sections(findings: Findings) -> list[Section]:
    """Return a line for the answer and the part on backlash; none for a study whose problems give no amplitude."""
    if "amplitude_rpm" not in findings.results.frame:
        return []
    known = units(findings)
    return [] if known is None else [*answer(findings, known), known]


def answer(findings: Findings, known: Section) -> list[Section]:
    """Return the line of the answer that a person remembers: the share of runs that found the best fit."""
    tables = {item.name: item.frame for item in known.items if isinstance(item, Table)}
    shares = tables.get(reference.NAME, pd.DataFrame()).get(reference.SHARE)
    if shares is None or len(findings.trials.optimizers) < 2 or findings.final.medians.empty:
        return []
    labels = [label for label in findings.from_leader if label in shares.index][:2]
    text = words.remembered([(label, float(shares[label])) for label in labels])
    return [Section("Answer", lines=(Line("in your units", text, TITLE),))]


def units(findings: Findings) -> Section | None:
    """Return the part on backlash; None where nothing is known of it."""
    results = findings.results
    frame = in_study_order(results.frame, results.study)
    truths, unknown = expected_values(results)
    found = {name: estimates(frame, truths, name) for name in FIGURES if name in frame}
    fits, table = reference.found_by_runs(results, frame, found)
    published, printed = fitting_errors.compared(results, frame)
    drawn = figures.drawn(findings, {name: data for name, data in found.items() if data["found"].notna().any()})
    items: tuple[Part, ...] = (*table, *printed, *drawn)
    return Section(TITLE, (*fits, *published), items, lines=_unknown(unknown)) if items else None


def _unknown(reasons: dict[str, str]) -> tuple[Line, ...]:
    """Return a line for each reason why true values are not known; a missing plug-in is one of many problems."""
    problems = {why: [label for label, other in reasons.items() if other == why] for why in reasons.values()}
    return tuple(Line("unknown", words.unknown(listing(labels, at_most=4), why)) for why, labels in problems.items())
