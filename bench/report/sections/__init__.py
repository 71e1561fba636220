"""The parts of every report, one a module: its TITLE, and the section it makes of the findings."""

from bench.report.sections import (
    across,
    anytime,
    beside,
    best,
    comparison,
    competition,
    components,
    datasets,
    dominance,
    environment,
    equivalence,
    integrity,
    landscape,
    matched,
    methods,
    portfolio,
    power,
    suite,
    time,
    trials,
    tuning,
    verdict,
)

OPENING = (verdict, matched, beside, suite, competition, dominance, integrity, comparison)
"""The parts before the plug-ins' sections."""

CLOSING = (
    tuning, components, across, equivalence, portfolio, landscape, anytime, best, datasets, time, trials, power,
    methods, environment,
)  # fmt: skip
"""The parts after them; the list of downloads ends the page."""
