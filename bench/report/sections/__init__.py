"""The parts that every study's report has, one a module; each takes the findings and returns its section."""

from bench.report.sections import (
    across,
    anytime,
    comparison,
    datasets,
    environment,
    integrity,
    methods,
    power,
    time,
    verdict,
)

OPENING = (verdict.section, integrity.section, comparison.section)
"""What comes before the plug-ins' sections."""

CLOSING = (
    across.section, anytime.section, datasets.section, time.section, power.section, methods.section,
    environment.section,
)  # fmt: skip
"""What comes after them; the list of downloads ends the page."""
