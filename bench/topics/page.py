"""The sections of the page, in their order, and those of strangers after them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from bench.plots import style
from bench.plugins import registry
from bench.report.parts import Figure, Section
from bench.report.write import Chapter
from bench.topics.answer import section as answer
from bench.topics.cost import section as cost
from bench.topics.course import section as course
from bench.topics.findings import Findings
from bench.topics.methods import section as methods
from bench.topics.runs import section as runs
from bench.topics.trust import section as trust
from bench.topics.units import section as units

Made = Section | Iterable[Section] | None

SECTIONS: tuple[tuple[str, Callable[[Findings], Section | None]], ...] = (
    (answer.TITLE, answer.section),
    (trust.TITLE, trust.section),
    (runs.TITLE, runs.section),
    (course.TITLE, course.section),
    (units.TITLE, units.section),
    (cost.TITLE, cost.section),
    (methods.TITLE, methods.section),
)

GROUP = "report_sections"
"""The entry points of strangers' sections: a section with the title of one above adds to it."""


def chapters(findings: Findings) -> list[Chapter]:
    """Return the chapters of a page: its seven sections, and one for every entry point."""
    return [
        *(Chapter(title, title, partial(_sections, make, findings)) for title, make in SECTIONS),
        *(
            Chapter(name, f"Section {name}", partial(_sections, partial(_installed, name), findings))
            for name in sorted(registry.entries(GROUP))
        ),
    ]


def _installed(name: str, findings: Findings) -> Made:
    """Return what the function of an entry point makes; raises what it raises, or its module where it is loaded."""
    made: Made = registry.load(GROUP, name)(findings)
    return made


def _sections(make: Callable[[Findings], Made], findings: Findings) -> list[Section]:
    """Return the sections that a function makes, with the subject's name marked in their figures."""
    made = make(findings)
    sections = [] if made is None else [made] if isinstance(made, Section) else list(made)
    if findings.subject:
        for part in (part for section in sections for part in (section, *section.sections)):
            for item in part.items:
                if isinstance(item, Figure):
                    style.mark(item.figure, findings.subject)
    return sections
