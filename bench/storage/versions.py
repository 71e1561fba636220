"""Identify the code that trials are made with: versions of installed packages, and the harness's own commit."""

from __future__ import annotations

import hashlib
import os
import subprocess
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from bench.plugins import registry
from bench.plugins.registry import is_installed

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
"""Distributions whose versions are noted; those that plug-ins load are among the inputs of trials."""

_SELF = Path(__file__).resolve()


def package_versions() -> dict[str, str]:
    """Return the versions of the installed ``PACKAGES``."""
    versions = {}
    for name in PACKAGES:
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
