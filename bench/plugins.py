"""Find and load plug-ins by entry point; built-ins have no privilege that a stranger's package lacks.

Groups: ``bench.optimizers``, ``bench.problems``, ``bench.commands``, ``bench.studies``, ``bench.report_sections``.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from bench import files
from bench.errors import BenchError, nearest
from bench.optimizer import Optimizer, build
from bench.problem import Problem

DISTRIBUTION = "backlash-bench"


@runtime_checkable
class Family(Protocol):
    """Many optimizers or problems behind one entry point, such as ``signature-01`` … ``signature-20``.

    A family of another library's optimizers may have an attribute ``extra``, the optional extra it needs.
    """

    def names(self) -> list[str]:
        """Return the full names that can be listed; a family may load others too (``recording:<path>``)."""

    def load(self, name: str, **options: Any) -> Any:
        """Return the plug-in of that full name; raises BenchError for what it does not know."""


@cache
def entries(group: str) -> dict[str, EntryPoint]:
    """Return the entry points of ``bench.<group>`` by name.

    Raises:
        BenchError: when two packages offer different plug-ins under one name.
    """
    refuse_foreign_modules()
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
    except Exception as error:  # a stranger's import may raise anything
        raise BenchError(
            f"the plug-in {name!r} of bench.{group} ({entries(group)[name].value}) failed to load: "
            f"{type(error).__name__}: {error}"
        ) from error


def load_optimizer(name: str, /, **options: Any) -> Optimizer:
    """Return the optimizer of that name, such as ``load_optimizer("gwo", agents=300)``.

    Args:
        name: an installed optimizer, a member of a family (``"mealpy:OriginalGWO"``), or a class or function of a file
            (``"path/to/file.py:ClassName"``).
        options: its parameters.

    Raises:
        BenchError: for an unknown name or parameter (with the nearest one) or a value out of its range.
    """
    if files.split(name):
        return build(files.load(name), name, options)
    family, colon, _ = name.partition(":")
    if name not in entries("optimizers") and not (colon and family in entries("optimizers")):
        raise BenchError(f"unknown optimizer {name!r}{nearest(name, entries('optimizers'))}")
    plugin = load("optimizers", family if name not in entries("optimizers") else name)
    if isinstance(plugin, type) and issubclass(plugin, Optimizer) and not colon:
        return build(plugin, name, options)
    if isinstance(plugin, Family) and colon:
        loaded = _ask(plugin.load, name, options)
        if isinstance(loaded, Optimizer):
            return loaded
    if is_family(plugin):
        raise BenchError(
            f"{name!r} is a family; name one of its optimizers, as in '{family}:<name>' (see 'bench list')"
        )
    raise BenchError(f"the plug-in behind {name!r} is no Optimizer subclass, nor a family named as '{family}:<name>'")


def load_problem(name: str, /, **options: Any) -> Problem:
    """Return the problem of that name, such as ``load_problem("signature-12", unit="rpm")``.

    Raises:
        BenchError: for an unknown name or option (with the nearest one) or data that cannot be read.
    """
    prefix, colon, _ = name.partition(":")
    families = entries("problems")
    if colon and prefix in families:
        return _problem(_ask(load("problems", prefix).load, name, options), name)
    for family in sorted(families, key=lambda family: not name.startswith(family)):
        try:
            plugin = load("problems", family)
            mine = name in plugin.names()
        except Exception as error:  # a broken family must not stand in the way of another's problem
            if name.startswith(family):
                raise BenchError(f"problem {name!r} cannot be looked up: {_first_line(error)}") from error
            continue
        if mine:
            return _problem(_ask(plugin.load, name, options), name)
    raise BenchError(f"unknown problem {name!r}{nearest(name, problem_names())}")


def _ask(loader: Callable[..., Any], name: str, options: dict[str, Any]) -> Any:
    """Call a family's loader; what a stranger's code raises becomes one sentence."""
    try:
        return loader(name, **options)
    except BenchError:
        raise
    except Exception as error:
        raise BenchError(f"{name!r} cannot be loaded: {type(error).__name__}: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]


def _problem(loaded: Any, name: str) -> Problem:
    if isinstance(loaded, Problem):
        return loaded
    raise BenchError(f"the plug-in behind {name!r} did not return a Problem but a {type(loaded).__name__}")


def matching(pattern: str) -> list[str]:
    """Return the members of a family that a pattern such as ``"mealpy:*GWO"`` stands for; another name is itself.

    Raises:
        BenchError: where no member fits, or the family's library is missing.
    """
    family, colon, member = pattern.partition(":")
    if not (colon and "*" in member) or files.split(pattern) or family not in entries("optimizers"):
        return [pattern]
    names: list[str] = fnmatch.filter(load("optimizers", family).names(), pattern)
    if not names:
        raise BenchError(f"no optimizer fits {pattern!r}; 'bench list {family}' shows those there are")
    return names


def problem_names() -> list[str]:
    """Return every problem name that can be listed."""
    names: list[str] = []
    for family in entries("problems"):
        with suppress(Exception):  # `bench list` shows it with its error
            names += load("problems", family).names()
    return sorted(names)


def is_family(plugin: Any) -> bool:
    """Return whether the object behind an entry point stands for many plug-ins."""
    return isinstance(plugin, Family) and not isinstance(plugin, type)


def refuse_foreign_modules() -> None:
    """Refuse to run where another package's module shadows one of this distribution's generic top-level names.

    Raises:
        BenchError: when the distribution is not installed, or ``optimizers`` or ``problems`` is somebody else's.
    """
    home = Path(__file__).resolve().parents[1]
    try:
        own = {entry.module.partition(".")[0] for entry in distribution(DISTRIBUTION).entry_points} - {"bench"}
    except PackageNotFoundError as error:
        raise BenchError(
            f"{DISTRIBUTION} is not installed here, so no plug-in can be found; run 'pip install -e .' in its folder"
        ) from error
    for module in sorted(own):
        spec = find_spec(module)
        origin = spec.origin if spec is not None else None
        if origin is None or Path(origin).resolve().parents[1] != home:
            raise BenchError(
                f"the module {module!r} found at {origin or 'no place'} is not {DISTRIBUTION}'s own, "
                f"which is in {home}; run from another folder or rename that module"
            )
