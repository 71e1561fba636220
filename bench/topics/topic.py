"""The entry points of ``bench.report_sections``: a :class:`Topic`, or a function that makes sections."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from bench.plugins import registry
from bench.report.parts import File, Section
from bench.topics.findings import Findings

GROUP = "report_sections"
PLACE = 500

Made = Section | Iterable[Section] | None


@dataclass(frozen=True)
class Topic:
    """A topic of a report.

    Attributes:
        title: its heading, and what is printed while its sections are made.
        make: returns the sections of a study's findings: one, several, or None for a study of another kind.
        place: topics stand in this order on the page; those of the same place by the names of their entry points.
        files: returns what the report's folder has of it besides the files of its tables and figures.
    """

    title: str
    make: Callable[[Findings], Made]
    place: int = PLACE
    files: Callable[[Findings], list[File]] = lambda _: []

    def sections(self, findings: Findings) -> list[Section]:
        """Return its sections for a study's findings."""
        made = self.make(findings)
        return [] if made is None else [made] if isinstance(made, Section) else list(made)


def topics() -> list[tuple[str, Topic]]:
    """Return every installed topic by the name of its entry point, in the order of the page.

    One that cannot be loaded raises the error when its sections are made.
    """
    loaded = [(name, _load(name)) for name in sorted(registry.entries(GROUP))]
    return sorted(loaded, key=lambda named: named[1].place)


def _load(name: str) -> Topic:
    title = f"Section {name}"
    try:
        plugin = registry.load(GROUP, name)
    except Exception as error:  # a stranger's module may raise anything
        return Topic(title, partial(_fail, error))
    return plugin if isinstance(plugin, Topic) else Topic(title, plugin)


def _fail(error: Exception, _: Findings) -> Made:
    raise error
