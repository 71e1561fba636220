"""The thesis's views of a study: Table 7.2, Figs. 7.3 to 7.5 and the best fit, in the section "In your units"."""

from bench.analysis import in_study_order
from bench.report import Line, Part, Section, listing
from bench.topics import Findings
from problems.backlash.report import figures, fitting_errors, reference, shares, words
from problems.backlash.report.accuracy import estimates, expected_values

TITLE = "In your units"
FIGURES = ("amplitude_rpm", "backlash_rad")


def sections(findings: Findings) -> list[Section]:
    """Return a line for the answer and the part on backlash; none for a study whose problems give no amplitude."""
    if "amplitude_rpm" not in findings.results.frame:
        return []
    return [made for made in (answer(findings), units(findings)) if made is not None]


def answer(findings: Findings) -> Section | None:
    """Return the line of the answer that a person remembers: the share of runs that found the best fit."""
    found = shares.shares(findings.results)
    if found.empty or len(findings.trials.optimizers) < 2 or findings.final.medians.empty:
        return None
    labels = [label for label in findings.from_leader if label in found.index][:2]
    text = words.remembered(str(found.columns[0]), [(label, float(found.iloc[:, 0][label])) for label in labels])
    return Section("Answer", lines=(Line("in your units", text, TITLE),))


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
