"""Identify the code that trials are made with: versions of installed packages, and the harness's own commit."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from bench.helpers.errors import BenchError
from bench.plugins import registry
from bench.plugins.registry import distributions_of, is_installed

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
"""Distributions whose versions are always noted."""

GROUPS = ("optimizers", "problems")
_SELF = Path(__file__).resolve()


def package_versions(modules: Iterable[str]) -> dict[str, str]:
    """Return the versions of the installed ``PACKAGES``, of the modules' distributions and of their requirements."""
    used = [(name, _extras(module)) for module in modules for name in distributions_of(module)]
    names = [*PACKAGES, *(needed for name, extras in used for needed in (name, *_requirements(name, extras)))]
    versions = {}
    for name in names:
        with suppress(PackageNotFoundError):
            package = distribution(name)
            versions[str(package.name)] = str(package.version)
    return versions


@cache
def own_state() -> dict[str, Any] | None:
    """Return the commit of the checkout that the harness runs from, and whether files of it were changed since.

    None outside a checkout, and where git cannot report it.
    """
    home = None if is_installed(_SELF) else next((up for up in _SELF.parents if (up / ".git").exists()), None)
    # In a hook, git's variables name another repository.
    plain = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    command = ["git", "-c", "core.fsmonitor=false", "describe", "--always", "--exclude=*", "--abbrev=40", "--dirty"]
    if home is None:
        return None
    try:
        found = subprocess.run(
            command, cwd=home, env=plain | {"GIT_OPTIONAL_LOCKS": "0"}, stdin=subprocess.DEVNULL, capture_output=True,
            check=True, timeout=60, text=True,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):  # git is missing, fails or takes too long
        return None
    commit, _, dirty = found.stdout.strip().partition("-")
    return {"commit": commit, "dirty": bool(dirty)}


def content_hash(path: Path) -> bytes:
    """Return the SHA-256 of a file's content, zeros where it cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
    return bytes(32)


def _extras(module: str) -> set[str]:
    """Return the optional extras that a module's families need."""
    extras = set()
    for group, entry in ((name, each) for name in GROUPS for each in registry.entries(name).values()):
        if entry.module == module:
            with suppress(BenchError):  # its trials report the error
                extras.add(str(getattr(registry.load(group, entry.name), "extra", "")))
    return extras


def _requirements(name: str, extras: set[str]) -> list[str]:
    """Return a distribution's requirements for these extras; for a third party's, also its unconditional ones."""
    wanted = extras - {""} if name == registry.DISTRIBUTION else extras | {""}
    required = []
    for text in distribution(name).requires or ():
        package, extra = re.match(r"[\w.-]+", text), re.search(r"""\bextra\s*==\s*['"]([^'"]+)""", text)
        if package and (extra[1] if extra else "") in wanted:
            required.append(package[0])
    return required
