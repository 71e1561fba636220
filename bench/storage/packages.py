"""The versions of the installed packages that trials are made with."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, packages_distributions
from importlib.util import find_spec
from pathlib import Path

from bench.errors import BenchError
from bench.plugins import registry

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
"""Distributions whose versions are always noted."""

SITES = ("site-packages", "dist-packages")
"""Folders of installed packages; what lies there is no part of a checkout around it."""


def versions(modules: Iterable[str]) -> dict[str, str]:
    """Return the versions of the installed ``PACKAGES``, of the modules' distributions and of their requirements."""
    names = list(PACKAGES)
    for module in modules:
        names += [each for name in distributions(module) for each in (name, *_requirements(name, _extras(module)))]
    found = {}
    for name in names:
        with suppress(PackageNotFoundError):
            package = distribution(name)
            found[str(package.name)] = str(package.version)
    return found


def _entries() -> Iterator[tuple[str, EntryPoint]]:
    """Yield group and entry point of every optimizer and problem."""
    for group in ("optimizers", "problems"):
        yield from ((group, entry) for entry in registry.entries(group).values())


def distributions(module: str) -> list[str]:
    """Return the names of the distributions that a module belongs to, none for a file that is not installed."""
    top = module.partition(".")[0]
    own = {entry.dist.name for _, entry in _entries() if entry.dist and entry.module.partition(".")[0] == top}
    if not own and (file := module_file(module)) and is_installed(file):
        own = {*packages_distributions().get(top, ())}
    return sorted(own)


def _extras(module: str) -> set[str]:
    """Return the optional extras that a module's families need."""
    extras = set()
    for group, entry in _entries():
        if entry.module == module:
            with suppress(BenchError):  # its trials report the error
                extras.add(str(getattr(registry.load(group, entry.name), "extra", "")))
    return extras


def _requirements(name: str, extras: set[str]) -> list[str]:
    """Return a distribution's requirements for these extras; for a third party's, also its unconditional ones."""
    wanted = extras - {""} if name == registry.DISTRIBUTION else extras | {""}
    found = []
    for text in distribution(name).requires or ():
        package, extra = re.match(r"[\w.-]+", text), re.search(r"""\bextra\s*==\s*['"]([^'"]+)""", text)
        if package and (extra[1] if extra else "") in wanted:
            found.append(package[0])
    return found


def module_file(module: str) -> Path | None:
    """Return the file of a module."""
    with suppress(Exception):  # a plug-in's package may raise anything
        spec = find_spec(module)
        return Path(spec.origin).resolve() if spec and spec.has_location and spec.origin else None
    return None


def is_installed(file: Path) -> bool:
    """Return whether a file is part of an installed package, not of a checkout."""
    return any(part in SITES for part in file.parts)
