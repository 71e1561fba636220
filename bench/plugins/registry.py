"""Find and load plug-ins by entry point; built-ins and third-party packages are treated alike.

Groups: ``bench.optimizers``, ``bench.problems``, ``bench.commands``, ``bench.studies`` and
``bench.report_sections``.
"""

from __future__ import annotations

import hashlib
import re
from base64 import urlsafe_b64encode
from contextlib import suppress
from functools import cache
from importlib.metadata import (
    Distribution,
    EntryPoint,
    PackageNotFoundError,
    distribution,
    distributions,
    entry_points,
    packages_distributions,
)
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from bench.contract.families import Grid
from bench.helpers.errors import BenchError, explained

DISTRIBUTION = "backlash-bench"


@runtime_checkable
class Family(Protocol):
    """Many optimizers or problems behind one entry point, such as ``signature-01`` … ``signature-20``.

    A family of another library's optimizers may have an attribute ``extra``, the optional extra it needs, and a family
    of problems an attribute ``grid`` (:class:`bench.Grid`), from which patterns and studies select.
    """

    def names(self) -> list[str]:
        """Return the full names that can be listed; the family may load others too (``recording:<path>``)."""

    def load(self, name: str, **options: object) -> Any:
        """Return the plug-in of that full name; raises BenchError for an unknown one."""


@cache
def entries(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of ``bench.<group>`` by name.

    Raises:
        BenchError: when two packages offer different plug-ins under one name, or a top-level module of this
            distribution is not its own.
    """
    for module in sorted({entry.module.partition(".")[0] for entry in own().entry_points}):
        if sentence := conflict(module):
            raise BenchError(sentence)
    plugins: dict[str, EntryPoint] = {}
    for entry in _readable(f"bench.{group}"):
        if not entry.pattern.match(entry.value):
            unreadable[entry.dist.name if entry.dist else entry.name] = f"{entry.value!r} is no 'module:object'"
            continue
        first = plugins.setdefault(entry.name, entry)
        if first.value != entry.value:
            raise BenchError(
                f"two plug-ins of bench.{group} are called {entry.name!r}: {first.value} and {entry.value}; "
                "uninstall one or have its author rename it"
            )
    return plugins


def _readable(group: str) -> list[EntryPoint]:
    """Return the entry points of a group, without those of packages whose entry points cannot be read."""
    try:
        return [*entry_points(group=group)]
    except Exception:  # of any package: its file may hold anything, and the others' are then read one by one
        packages: dict[str, list[EntryPoint]] = {}
        for installed in distributions():
            try:
                packages.setdefault(installed.name, [*installed.entry_points.select(group=group)])
            except Exception as error:
                unreadable[installed.name] = f"{type(error).__name__}: {error}"
        return [entry for those in packages.values() for entry in those]


unreadable: dict[str, str] = {}
"""Why the entry points of installed packages could not be read so far, by the package's name."""


def entry(group: str, name: str) -> EntryPoint | None:
    """Return the entry point of a plug-in or, for ``family:member``, of its family; None where there is none."""
    return entries(group).get(name) or entries(group).get(name.partition(":")[0])


@cache
def load(group: str, name: str) -> Any:
    """Return the object behind an entry point; raises BenchError when its package fails to import.

    A package that ends the process where it is imported (``sys.exit``) fails, too.
    """
    found = entries(group)[name]
    what = f"the plug-in {name!r} of bench.{group} ({found.value}) failed to load"
    with explained(what, (Exception, SystemExit, GeneratorExit)):  # an import may raise anything
        return found.load()


def package(group: str, name: str) -> str:
    """Return the name and version of the package that offers an entry point, "" where there is none."""
    entry = entries(group).get(name)
    return f"{entry.dist.name} {entry.dist.version}" if entry is not None and entry.dist is not None else ""


def distributions_of(module: str) -> list[str]:
    """Return the names of the distributions that a module belongs to, none for a file that is not installed."""
    top = module.partition(".")[0]
    plugins = (entry for group in ("optimizers", "problems") for entry in entries(group).values())
    found = {entry.dist.name for entry in plugins if entry.dist and entry.module.partition(".")[0] == top}
    with suppress(PackageNotFoundError, ValueError):  # as a rule it has the module's name, and no other is looked at
        named = distribution(top)
        if not found and any(Path(str(named.locate_file(f"{top}{end}"))).exists() for end in ("", ".py")):
            return [named.name]
    return sorted(found) or sorted(set(_distributions().get(top, [])))


_distributions = cache(packages_distributions)


def is_installed(file: Path) -> bool:
    """Return whether a file is part of an installed package, which is no part of a checkout around it."""
    return not {"site-packages", "dist-packages"}.isdisjoint(file.parts)


def is_family(plugin: object) -> bool:
    """Return whether the object behind an entry point is a family of plug-ins."""
    return isinstance(plugin, Family) and not isinstance(plugin, type)


def grid(family: str) -> Grid | None:
    """Return the functions of a suite, None for another family of problems; raises BenchError as :func:`load`."""
    functions = getattr(load("problems", family), "grid", None)
    return functions if isinstance(functions, Grid) else None


def own() -> Distribution:
    """Return the installed distribution of the harness; raises BenchError where it is not installed."""
    try:
        return distribution(DISTRIBUTION)
    except PackageNotFoundError as error:
        raise BenchError(
            f"{DISTRIBUTION} is not installed here, so no plug-in can be found; run 'pip install -e .' in its folder"
        ) from error


def conflict(module: str) -> str:
    """Return in one sentence why a top-level module of this distribution is not its own, "" where it is.

    Its name is a common one. Another package may have a module of that name earlier on the path, or, installed into
    the same folder, have replaced its files or removed them.
    """
    home = Path(__file__).resolve().parents[2]
    origin = getattr(find_spec(module), "origin", None)
    if origin is not None and Path(origin).resolve().parents[1] == home:
        noted = re.search(rf"^{module}/__init__\.py,sha256=([^,]+),", own().read_text("RECORD") or "", re.MULTILINE)
        found = urlsafe_b64encode(hashlib.sha256(Path(origin).read_bytes()).digest()).decode().rstrip("=")
        if noted is None or noted[1] == found:  # an editable installation notes none
            return ""
    return (
        f"the module {module!r} found at {origin or 'no place'} is not the one of {DISTRIBUTION} in {home}: another "
        f"package or file has its name; rename that, or keep the two in environments of their own and run 'pip install "
        f"--force-reinstall --no-deps {DISTRIBUTION}'"
    )
