"""Record and compare where results come from: machine, versions, code and run.

A study's ``environment.json`` is a list of flat records, one for each run on each machine that took part in it:
``machine(…) | run(…)``. ARCHITECTURE.md describes each key.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shlex
import socket
import subprocess
import sys
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import psutil
from threadpoolctl import threadpool_info

from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.plugins import registry
from bench.study import Study

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
"""Distributions whose versions are noted; those that plug-ins load are among the inputs of trials."""

LONGEST = 10_000
"""Characters noted of a text, such as a command with all its arguments."""

CONTAINER_LIMITS = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))
"""Files with a container's memory limit on Linux: of control groups version 2 and version 1."""


def machine() -> JsonObject:
    """Return the record of this process and its machine."""
    affinity = getattr(os, "sched_getaffinity", None)
    return {
        "packages": package_versions(),
        "python": platform.python_version(),
        "system": platform.platform(),
        "host": host(),
        "processor": _processor(),
        "cores": len(affinity(0)) if affinity else os.cpu_count(),
        "memory_gb": round(memory() / 1e9, 1),
        "blas": blas(),
        "harness": package(),
        "git": own_state(),
    }


def united(record: JsonObject, other: JsonObject) -> JsonObject:
    """Return a machine's record with the BLAS that only another process's record has."""
    blas = [*record["blas"], *(library for library in other.get("blas") or () if library not in record["blas"])]
    return dict(record) | {"blas": sorted(blas, key=str)}


def run(
    study: Study,
    jobs: int,
    backend: str,
    *,
    timeout: float | None = None,
    shard: str | None = None,
    untrusted: bool = False,
) -> JsonObject:
    """Return the record of a run that starts now; its ``timeout`` is in seconds, its ``shard`` as in "3/20"."""
    return {
        "started": now(),
        "ended": None,
        "command": command(),
        "working_folder": str(Path.cwd()),
        "jobs": jobs,
        "backend": backend,
        "study": study.identity(),
        "timeout": timeout,
        "shard": shard,
        "sandbox": "bwrap" if untrusted else None,
        "trials": study.trials,
        "subject": study.subject,
    }


def command() -> str:
    """Return the command line as typed, as far as it is known, for a shell."""
    program = Path(sys.argv[0])
    words = ["python", "-m", program.parent.name] if program.name == "__main__.py" else [program.name]
    return printable(shlex.join([*words, *sys.argv[1:]]), LONGEST)


def differences(before: JsonObject, now: JsonObject) -> list[str]:
    """Return in short phrases the differences of two records that may change results or times: ``"numpy 2.4 → 2.5"``.

    Not compared: keys that one record lacks, the kernel's build, and the name, cores and memory of the machine; what
    plug-ins read is in the inputs of each row (:mod:`bench.plugins.inputs`).
    """
    old, new = _versions(before), _versions(now)
    phrases = [f"{what} {old[what]} → {new[what]}" for what in old if what in new and old[what] != new[what]]
    records = (record.get("blas") or () for record in (before, now))
    old_blas, new_blas = ({f"{blas.get('library')} {blas.get('version')}" for blas in record} for record in records)
    if not (old_blas <= new_blas or new_blas <= old_blas):  # libraries are loaded as they are needed
        phrases.append(f"BLAS {', '.join(sorted(old_blas))} → {', '.join(sorted(new_blas))}")
    if bool(before.get("imported")) != bool(now.get("imported")):
        phrases.append("imported results" if now.get("imported") else "results that are not imported")
    return phrases


@cache
def package() -> str:
    """Return the harness's name and version with a hash of its code, as a development version has many states."""
    harness = distribution(registry.DISTRIBUTION)
    home = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for top in sorted({entry.module.partition(".")[0] for entry in harness.entry_points}):
        for file in sorted((home / top).rglob("*.py")):
            content = b""
            with suppress(OSError):  # of problems that a sandbox hides
                content = hashlib.sha256(file.read_bytes()).digest()
            digest.update(file.relative_to(home).as_posix().encode() + b"\0" + content)
    return f"{registry.DISTRIBUTION} {harness.version} (code {digest.hexdigest()[:8]})"


def host() -> str:
    """Return the machine's name."""
    return printable(socket.gethostname(), LONGEST)


def memory() -> int:
    """Return the bytes of memory of the machine, or the limit that a container or a batch system sets."""
    limits = [int(psutil.virtual_memory().total)]
    for file in CONTAINER_LIMITS:
        with suppress(OSError, ValueError):  # "max" is no limit
            limits.append(int(file.read_text()))
    return min(limits)


def now() -> str:
    """Return the time in UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


# differences


def _versions(record: JsonObject) -> dict[str, str]:
    """Return all versions that are compared as texts, by name."""
    system = str(record.get("system") or "")
    if system.startswith("Linux"):  # the C library computes sines and logarithms; the kernel does not
        system = f"Linux {system.partition('-with-')[2]}".strip()
    named = {"Python": record.get("python"), "processor": record.get("processor"), "system": system}
    packages = dict(record.get("packages") or {})
    if harness := record.get("harness"):
        name, _, state = str(harness).partition(" ")
        packages[name] = state  # with the hash of its code
    return {what: str(value) for what, value in (packages | named).items() if value}


# the machine and its versions


def package_versions() -> dict[str, str]:
    """Return the versions of the installed ``PACKAGES``."""
    versions = {}
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            package = distribution(name)
            versions[str(package.name)] = str(package.version)
    return versions


@cache
def own_state(file: Path = Path(__file__)) -> JsonObject | None:
    """Return the commit of the checkout that a file is in, and whether files of the checkout were changed since.

    None of an installed package, outside a checkout, and where git cannot report it.
    """
    if registry.is_installed(file):
        return None
    # In a hook, git's variables name another repository.
    plain = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    command = ["git", "-c", "core.fsmonitor=false", "describe", "--always", "--exclude=*", "--abbrev=40", "--dirty"]
    try:
        found = subprocess.run(
            command, cwd=file.resolve().parent, env=plain | {"GIT_OPTIONAL_LOCKS": "0"}, stdin=subprocess.DEVNULL,
            capture_output=True, check=True, timeout=60, text=True,
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):  # git is missing, fails or takes too long
        return None
    commit, _, dirty = found.stdout.strip().partition("-")
    return {"commit": commit, "dirty": bool(dirty)}


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def blas() -> list[JsonObject]:
    """Return library, version and threads of every BLAS that this process has loaded."""
    keys = {"library": "internal_api", "version": "version", "threads": "num_threads"}
    loaded = [library for library in threadpool_info() if library["user_api"] == "blas"]
    distinct = {tuple(library[key] for key in keys.values()) for library in loaded}
    return [dict(zip(keys, values, strict=True)) for values in sorted(distinct, key=str)]
