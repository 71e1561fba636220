"""Complete names for the shell's Tab key: optimizers, problems, studies and the folders of studies.

A completer returns what begins with the typed text, or nothing, where a shell completes files instead. It imports as
few plug-ins as it can; a plug-in that fails to load is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.plugins import registry

MOST = 40
"""More names than this are completed part by part: ``bbob-`` offers functions, ``bbob-f08-`` dimensions."""

RUNS = Path("results/runs")


def optimizers(incomplete: str) -> list[str]:
    """Return the installed optimizers; of a family only its name, as its library may take seconds to import."""
    return starting(_entries("optimizers"), incomplete)


def checkable(incomplete: str) -> list[str]:
    """Return optimizers and the folders of studies."""
    return [*optimizers(incomplete), *folders(incomplete)]


def problems(incomplete: str) -> list[str]:
    """Return the names of problems, in parts where there are many."""
    return by_parts(starting(_problems(incomplete), incomplete), incomplete)


def studies(incomplete: str) -> list[str]:
    """Return the installed studies and the TOML files of the current folder."""
    with suppress(OSError):
        return starting([*_entries("studies"), *(path.name for path in Path().glob("*.toml"))], incomplete)
    return []


def folders(incomplete: str) -> list[str]:
    """Return the folders of studies, in ``results/runs`` and in the current folder."""
    paths: list[str] = []
    for place in (RUNS, Path()):
        with suppress(OSError):
            paths += [path.parent.as_posix() for path in place.glob("*/study.toml")]
    return starting(paths, incomplete)


def by_parts(names: Iterable[str], typed: str) -> list[str]:
    """Return the names, or, where they are more than ``MOST``, their beginnings up to the next hyphen in which they
    differ.
    """
    every = list(dict.fromkeys(names))
    while len(every) > MOST:
        beginnings = list(dict.fromkeys(name[: name.find("-", len(typed)) + 1] or name for name in every))
        if len(beginnings) > 1:
            return beginnings
        typed = beginnings[0]
    return every


def _problems(typed: str) -> Iterator[str]:
    for name in _entries("problems"):
        with suppress(Exception):  # a broken family must not hide another's problems
            family: Any = registry.load("problems", name)
            whole = hasattr(family, "grid") and typed.startswith(f"{name}-")  # of others, the first instances suffice
            yield from family.grid.names() if whole else family.names()


def _entries(group: str) -> list[str]:
    with suppress(BenchError):
        return list(registry.entries(group))
    return []


def starting(names: Iterable[str], typed: str) -> list[str]:
    """Return the names that begin with the typed text, sorted."""
    return sorted({name for name in names if name.startswith(typed)})
