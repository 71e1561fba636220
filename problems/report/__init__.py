"""The thesis's own views of a study: Table 7.2 and Fig. 7.4 (Fig. 7.5 is every report's timing figure)."""

from bench import Results
from bench.report import Section
from problems.report import amplitudes, fitting_errors


def sections(results: Results) -> list[Section]:
    """Return the sections on backlash, none for a study whose problems give no amplitude."""
    if "amplitude_rpm" not in results.frame:
        return []
    return [*fitting_errors.sections(results), *amplitudes.sections(results)]
