"""The thesis's views of a study: Figs. 7.3 to 7.5, its tables of chapters 7 and 8, and the best fit."""

from bench.analysis import in_study_order
from bench.report import Section
from bench.topics import Findings
from problems.backlash.report import amplitudes, fitting_errors, levels, noise, reference, wrist
from problems.backlash.report.accuracy import expected_values


def sections(findings: Findings) -> list[Section]:
    """Return the sections on backlash, none for a study whose problems give no amplitude."""
    results = findings.results
    if "amplitude_rpm" not in results.frame:
        return []
    frame = in_study_order(results.frame, results.study)
    truths, unknown = expected_values(results)
    return [
        *levels.sections(frame, truths, unknown),
        *fitting_errors.sections(results, frame),
        *reference.sections(results, frame),
        *amplitudes.sections(frame, truths, results.study),
        *noise.sections(results, frame, truths),
        *wrist.sections(results, frame, truths),
    ]
