"""The thesis's views of a study: Table 7.2, Figs. 7.3 to 7.5 and the best fit, in the section "In your units"."""

from bench.analysis import in_study_order
from bench.report import Part, Section, listing
from bench.topics import Findings
from problems.backlash.report import figures, fitting_errors, reference, words
from problems.backlash.report.accuracy import estimates, expected_values

TITLE = "In your units"
FIGURES = ("amplitude_rpm", "backlash_rad")


def section(findings: Findings) -> Section | None:
    """Return the part on backlash, None for a study whose problems give no amplitude."""
    results = findings.results
    if "amplitude_rpm" not in results.frame:
        return None
    frame = in_study_order(results.frame, results.study)
    truths, unknown = expected_values(results)
    found = {name: estimates(frame, truths, name) for name in FIGURES if name in frame}
    fits, table = reference.found_by_runs(results, frame, found)
    published, printed = fitting_errors.compared(results, frame)
    drawn = figures.drawn(findings, {name: data for name, data in found.items() if data["found"].notna().any()})
    items: tuple[Part, ...] = (*table, *printed, *drawn)
    return Section(TITLE, (*fits, *published), items, _unknown(unknown)) if items else None


def _unknown(reasons: dict[str, str]) -> tuple[str, ...]:
    """Return a warning for each reason why true values are not known; a missing plug-in is one of many problems."""
    problems = {why: [label for label, other in reasons.items() if other == why] for why in reasons.values()}
    return tuple(words.unknown(listing(labels, at_most=4), why) for why, labels in problems.items())
