"""Find and load plug-ins by entry point; built-ins and third-party packages are treated alike.

Groups: ``bench.optimizers``, ``bench.problems``, ``bench.commands``, ``bench.studies``, ``bench.report_sections``.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from bench.errors import BenchError

DISTRIBUTION = "backlash-bench"


@runtime_checkable
class Family(Protocol):
    """Many optimizers or problems behind one entry point, such as ``signature-01`` … ``signature-20``.

    A family of another library's optimizers may have an attribute ``extra``, the optional extra it needs, and a family
    of problems an attribute ``grid`` (:class:`bench.Grid`), from which patterns and studies select.
    """

    def names(self) -> list[str]:
        """Return the full names that can be listed; the family may load others too (``recording:<path>``)."""

    def load(self, name: str, **options: Any) -> Any:
        """Return the plug-in of that full name; raises BenchError for an unknown one."""


@cache
def entries(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of ``bench.<group>`` by name.

    Raises:
        BenchError: when two packages offer different plug-ins under one name.
    """
    _refuse_foreign_modules()
    found: dict[str, EntryPoint] = {}
    for entry in entry_points(group=f"bench.{group}"):
        other = found.setdefault(entry.name, entry)
        if other.value != entry.value:
            raise BenchError(
                f"two plug-ins of bench.{group} are called {entry.name!r}: {other.value} and {entry.value}; "
                "uninstall one or have its author rename it"
            )
    return found


@cache
def load(group: str, name: str) -> Any:
    """Return the object behind an entry point; raises BenchError when its package fails to import."""
    try:
        return entries(group)[name].load()
    except Exception as error:  # an import may raise anything
        raise BenchError(
            f"the plug-in {name!r} of bench.{group} ({entries(group)[name].value}) failed to load: "
            f"{type(error).__name__}: {error}"
        ) from error


def package(group: str, name: str) -> str:
    """Return the name and version of the package that offers an entry point, "" where there is none."""
    found = entries(group).get(name)
    return f"{found.dist.name} {found.dist.version}" if found is not None and found.dist is not None else ""


def is_family(plugin: Any) -> bool:
    """Return whether the object behind an entry point is a family of plug-ins."""
    return isinstance(plugin, Family) and not isinstance(plugin, type)


def _refuse_foreign_modules() -> None:
    """Refuse to run where another package's module shadows a top-level module of this distribution.

    Raises:
        BenchError: when the distribution is not installed, or ``optimizers`` or ``problems`` is another package's.
    """
    home = Path(__file__).resolve().parents[2]
    try:
        own = {entry.module.partition(".")[0] for entry in distribution(DISTRIBUTION).entry_points} - {"bench"}
    except PackageNotFoundError as error:
        raise BenchError(
            f"{DISTRIBUTION} is not installed here, so no plug-in can be found; run 'pip install -e .' in its folder"
        ) from error
    for module in sorted(own):
        origin = getattr(find_spec(module), "origin", None)
        if origin is None or Path(origin).resolve().parents[1] != home:
            raise BenchError(
                f"the module {module!r} found at {origin or 'no place'} is not the one of {DISTRIBUTION} "
                f"in {home}; run from another folder or rename that module"
            )
