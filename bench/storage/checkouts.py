"""The state of the git checkouts that the harness and the plug-ins run from."""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib.machinery import all_suffixes
from pathlib import Path
from typing import Any

from bench.storage import packages
from bench.text import printable, unique

SOURCES = (*all_suffixes(), ".pyx", ".pxd", ".c", ".cc", ".cpp", ".cu", ".h", ".hpp", ".f", ".f90", ".rs", ".jl")
"""Suffixes of code files; other untracked files, such as a run's own log, do not change what runs."""


def states(modules: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the states of the modules' checkouts by distribution or folder name, without the harness's own."""
    homes: dict[Path, str] = {}
    for module in modules:
        if (file := packages.module_file(module)) and (home := _home(file)) and home != _home(Path(__file__).resolve()):
            homes.setdefault(home, next(iter(packages.distributions(module)), printable(home.name, 255)))
    found = zip(unique(homes.values()), map(_state, homes), strict=True)
    return {name: state for name, state in found if state}


def state_of(file: Path) -> dict[str, Any] | None:
    """Return the state of the checkout that a file is part of, None outside one."""
    home = _home(file)
    return _state(home) if home else None


def _home(file: Path) -> Path | None:
    """Return the folder of the checkout that a file is part of."""
    with suppress(OSError):
        if not packages.is_installed(file):
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
    new = [name for name in map(os.fsdecode, unknown.split(b"\0")) if _is_code(name)]
    names = sorted({*filter(None, map(os.fsdecode, changed.split(b"\0"))), *new})
    digest = hashlib.sha256()
    for name in names:
        digest.update(os.fsencode(name) + b"\0" + content_hash(home / name))
    return {"commit": commit.decode().strip(), "dirty": bool(names), "diff": digest.hexdigest() if names else None}


def _is_code(name: str) -> bool:
    """Return whether an untracked file may change what runs; cached bytecode follows its source."""
    return name.endswith(SOURCES) and "__pycache__" not in name.split("/")


def content_hash(path: Path) -> bytes:
    """Return the SHA-256 of a file's content, zeros where it cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
    return bytes(32)


def _git(home: Path, *arguments: str) -> bytes | None:
    """Return git's output, None where git is missing, fails or times out."""
    plain = {
        key: value for key, value in os.environ.items() if not key.startswith("GIT_")
    }  # in a hook they name another repository
    try:
        return subprocess.run(
            ["git", "-C", home, "-c", "core.fsmonitor=false", *arguments],
            stdin=subprocess.DEVNULL, capture_output=True, check=True, timeout=60,
            env=plain | {"GIT_OPTIONAL_LOCKS": "0"},
        ).stdout  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
