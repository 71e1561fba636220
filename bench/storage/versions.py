"""Identify the code that trials are made with: versions of installed packages, and states of git checkouts."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib.machinery import all_suffixes
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.helpers.text import printable, unique
from bench.plugins import registry
from bench.plugins.registry import distributions_of, is_installed

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
"""Distributions whose versions are always noted."""

SOURCES = (*all_suffixes(), ".pyx", ".pxd", ".c", ".cc", ".cpp", ".cu", ".h", ".hpp", ".f", ".f90", ".rs", ".jl")
"""Suffixes of code files; other untracked files, such as a run's own log, do not change what runs."""

_SELF = Path(__file__).resolve()


def package_versions(modules: Iterable[str]) -> dict[str, str]:
    """Return the versions of the installed ``PACKAGES``, of the modules' distributions and of their requirements."""
    names = list(PACKAGES)
    for module in modules:
        names += [
            needed for name in distributions_of(module) for needed in (name, *_requirements(name, _extras(module)))
        ]
    versions = {}
    for name in names:
        with suppress(PackageNotFoundError):
            package = distribution(name)
            versions[str(package.name)] = str(package.version)
    return versions


def own_state() -> dict[str, Any] | None:
    """Return the state of the harness's own checkout, None outside one."""
    home = _home(_SELF)
    return _state(home) if home else None


def checkout_states(modules: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the states of the modules' checkouts by distribution or folder name, without the harness's own."""
    homes: dict[Path, str] = {}
    for module in modules:
        if (file := _module_file(module)) and (home := _home(file)) and home != _home(_SELF):
            homes.setdefault(home, next(iter(distributions_of(module)), printable(home.name, 255)))
    states = zip(unique(homes.values()), map(_state, homes), strict=True)
    return {name: state for name, state in states if state}


def content_hash(path: Path) -> bytes:
    """Return the SHA-256 of a file's content, zeros where it cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
    return bytes(32)


# installed packages


def _plugins() -> Iterator[tuple[str, EntryPoint]]:
    """Yield group and entry point of every optimizer and problem."""
    for group in ("optimizers", "problems"):
        yield from ((group, entry) for entry in registry.entries(group).values())


def _extras(module: str) -> set[str]:
    """Return the optional extras that a module's families need."""
    extras = set()
    for group, entry in _plugins():
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


def _module_file(module: str) -> Path | None:
    with suppress(Exception):  # a plug-in's package may raise anything
        spec = find_spec(module)
        return Path(spec.origin).resolve() if spec and spec.has_location and spec.origin else None
    return None


# checkouts


def _home(file: Path) -> Path | None:
    """Return the folder of the checkout that a file is part of."""
    with suppress(OSError):
        if not is_installed(file):
            return next((up for up in file.parents if (up / ".git").exists()), None)
    return None


@cache
def _state(home: Path) -> dict[str, Any] | None:
    """Return commit and uncommitted changes of a checkout, None where git cannot report them.

    ``diff`` is a SHA-256 of the names and contents of all files that differ from the commit or are code that git does
    not know, and None where there are none: unlike a patch, it depends on no setting and no version of git.
    """
    commit = _git(home, "rev-parse", "HEAD")
    changed = _git(home, "diff", "HEAD", "--name-only", "--no-renames", "--no-ext-diff", "-z")
    unknown = _git(home, "ls-files", "--others", "--exclude-standard", "-z")
    if commit is None or changed is None or unknown is None:
        return None
    added = map(os.fsdecode, unknown.split(b"\0"))  # cached bytecode follows its source
    new = [name for name in added if name.endswith(SOURCES) and "__pycache__" not in name.split("/")]
    names = sorted({*filter(None, map(os.fsdecode, changed.split(b"\0"))), *new})
    digest = hashlib.sha256()
    for name in names:
        digest.update(os.fsencode(name) + b"\0" + content_hash(home / name))
    return {"commit": commit.decode().strip(), "dirty": bool(names), "diff": digest.hexdigest() if names else None}


def _git(home: Path, *arguments: str) -> bytes | None:
    """Return git's output, None where git is missing, fails or times out."""
    # In a hook, git's variables name another repository.
    plain = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    try:
        return subprocess.run(
            ["git", "-C", home, "-c", "core.fsmonitor=false", *arguments],
            stdin=subprocess.DEVNULL, capture_output=True, check=True, timeout=60,
            env=plain | {"GIT_OPTIONAL_LOCKS": "0"},
        ).stdout  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
