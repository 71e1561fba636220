"""Hang sections that have not moved yet in the section of the page to which their content goes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from bench.report.parts import File, Section
from bench.topics.findings import Findings


def hung(
    findings: Findings,
    title: str,
    *makers: Callable[[Findings], Section | None],
    files: tuple[Callable[[Findings], list[File]], ...] = (),
) -> Section | None:
    """Return a section whose subsections these functions make; None where none makes any."""
    made = [section for make in makers if (section := make(findings)) is not None]
    parts = tuple(part for section in made for part in (replace(section, sections=()), *section.sections))
    written = tuple(file for make in files for file in make(findings))
    return Section(title, sections=parts, files=written) if parts else None
