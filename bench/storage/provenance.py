"""Where results come from: the machine, the versions and the code that made them, and the run that asked for them.

A study's ``environment.json`` is a list of flat records, one for each run on each machine that took part in it:
``machine(…) | run(…)``. Each of them holds

==============  =====================================================================================================
packages        version by distribution: this one, the numerical libraries, and those of the plug-ins in use
python          version of Python
system          the operating system, as :func:`platform.platform` tells it
host            the machine's own name
processor       its model
cores           those that the process may use
memory_gb       what of the machine's memory the process may use, in 10⁹ bytes
blas            ``{"library", "version", "threads"}`` of every BLAS that the process has loaded
git             commit of the checkout that the harness runs from, ``{"commit", "dirty", "diff"}``; None outside one
checkouts       the same of the plug-ins' own checkouts, by distribution or by the checkout's folder
started, ended  in UTC, ISO 8601; a run that was killed has no end
command         as typed, for a shell
jobs, backend   trials at a time, and what distributes them
study           hash of all that decides a trial's result (:meth:`bench.study.Study.identity`)
data            hash of every problem's data, by label
code            hash of every optimizer's file, by label; installed optimizers have none
timeout, shard  the limit of a trial in seconds and the share of the study that was asked for; None without
==============  =====================================================================================================

Records of older versions lack some of these.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shlex
import socket
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.machinery import all_suffixes
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, packages_distributions
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import psutil
from threadpoolctl import threadpool_info

from bench.errors import BenchError
from bench.plugins import registry
from bench.study import Fingerprints, Study
from bench.text import printable, unique

PACKAGES = (registry.DISTRIBUTION, "numpy", "scipy", "numba", "cma", "joblib", "pandas")
LONGEST = 10_000
"""Letters of a text that are noted, such as of a command with all its arguments."""

SITES = ("site-packages", "dist-packages")
"""Folders of installed packages; what lies there is no part of a checkout around it."""

CONTAINER_LIMITS = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))
"""Where Linux tells a container how much memory it may use: in version 2 of control groups, and in version 1."""

SOURCES = (*all_suffixes(), ".pyx", ".pxd", ".c", ".cc", ".cpp", ".cu", ".h", ".hpp", ".f", ".f90", ".rs", ".jl")
"""How names of code end; other untracked files, such as a run's own log, change nothing that runs."""


def machine(plugins: Sequence[str] = ()) -> dict[str, Any]:
    """Return what describes this process and its machine; it is the same every time on one of them.

    Args:
        plugins: the importable names of the modules that the plug-ins in use come from (:func:`modules`).
    """
    affinity = getattr(os, "sched_getaffinity", None)
    return {
        "packages": _packages(plugins),
        "python": platform.python_version(),
        "system": platform.platform(),
        "host": host(),
        "processor": _processor(),
        "cores": len(affinity(0)) if affinity else os.cpu_count(),
        "memory_gb": round(memory() / 1e9, 1),
        "blas": _blas(),
        "git": _git_of(Path(__file__).resolve()),
        "checkouts": _checkouts(plugins),
    }


def run(
    study: Study,
    fingerprints: Fingerprints,
    jobs: int,
    backend: str,
    *,
    timeout: float | None = None,
    shard: str | None = None,
) -> dict[str, Any]:
    """Return what describes a run that starts now.

    Args:
        study: what is run.
        fingerprints: of its problems' data and its optimizers' files.
        jobs: trials at a time.
        backend: what distributes them.
        timeout: the limit of a trial in seconds.
        shard: the share of the study that is run here.
    """
    return {
        "started": now(),
        "ended": None,
        "command": _command(),
        "jobs": jobs,
        "backend": backend,
        "study": study.identity(),
        "data": fingerprints.data,
        "code": fingerprints.code,
        "timeout": timeout,
        "shard": shard,
    }


def _command() -> str:
    """Return what was typed, as far as it can be told."""
    program = Path(sys.argv[0])
    words = ["python", "-m", program.parent.name] if program.name == "__main__.py" else [program.name]
    return printable(shlex.join([*words, *sys.argv[1:]]), LONGEST)


def modules(plugins: Iterable[object]) -> list[str]:
    """Return the names of the modules that plug-ins come from: of their classes and of the functions they hold."""
    found: set[str] = set()
    for plugin in plugins:
        kind = type(plugin)
        held = [*vars(kind).values(), *getattr(plugin, "__dict__", {}).values()]
        owners = [*kind.__mro__, *(each for each in held if callable(each) and not isinstance(each, type))]
        found |= {name for owner in owners if isinstance(name := getattr(owner, "__module__", None), str)}
    return sorted(name for name in found if name.partition(".")[0] not in {"bench", *sys.stdlib_module_names})


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return in short phrases what may change results or times from one record to another: ``"numpy 2.4 → 2.5"``.

    What one of them does not tell is not compared; nor are the kernel's build and the machine's name, cores and memory.
    """
    old, new = _versions(before), _versions(now)
    phrases = [f"{what} {old[what]} → {new[what]}" for what in old if what in new and old[what] != new[what]]
    old_blas, new_blas = (
        {f"{each.get('library')} {each.get('version')}" for each in record.get("blas") or ()}
        for record in (before, now)
    )
    if not (old_blas <= new_blas or new_blas <= old_blas):  # libraries are loaded as they are needed
        phrases.append(f"BLAS {', '.join(sorted(old_blas))} → {', '.join(sorted(new_blas))}")
    if "git" in before and "git" in now:
        phrases += _changes(before["git"], now["git"])
    own, other = (record.get("checkouts") or {} for record in (before, now))
    phrases += [f"{name}: {change}" for name in own if name in other for change in _changes(own[name], other[name])]
    return phrases


@cache
def package() -> str:
    """Return the name and version of this harness, and a hash of its code: a version in the making may be many."""
    own = distribution(registry.DISTRIBUTION)
    home = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for top in sorted({entry.module.partition(".")[0] for entry in own.entry_points}):
        for file in sorted((home / top).rglob("*.py")):
            digest.update(file.relative_to(home).as_posix().encode() + b"\0" + _content(file))
    return f"{registry.DISTRIBUTION} {own.version} (code {digest.hexdigest()[:8]})"


def host() -> str:
    """Return the machine's own name."""
    return printable(socket.gethostname(), LONGEST)


def memory() -> int:
    """Return the bytes of memory that the machine has, or that a container or a batch system lets its processes use."""
    limits = [int(psutil.virtual_memory().total)]
    for file in CONTAINER_LIMITS:
        with suppress(OSError, ValueError):  # "max" is no limit
            limits.append(int(file.read_text()))
    return min(limits)


def now() -> str:
    """Return the time in UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


# what differs


def _versions(record: Mapping[str, Any]) -> dict[str, str]:
    """Return all that is compared as it stands, by what to call it."""
    system = str(record.get("system") or "")
    if system.startswith("Linux"):  # the C library computes sines and logarithms; the kernel does not
        system = f"Linux {system.partition('-with-')[2]}".strip()
    named = {"Python": record.get("python"), "processor": record.get("processor"), "system": system}
    return {what: str(value) for what, value in ((record.get("packages") or {}) | named).items() if value}


def _changes(before: Mapping[str, Any] | None, now: Mapping[str, Any] | None) -> Iterator[str]:
    """Yield what differs between two states of a checkout; None is none."""
    before, now = before or {}, now or {}
    old, new = (str(state.get("commit") or "unknown") for state in (before, now))
    if old != new:
        yield f"commit {old[:7]} → {new[:7]}"
    if bool(before.get("dirty")) != bool(now.get("dirty")):
        yield "uncommitted changes" if now.get("dirty") else "no uncommitted changes"
    elif before.get("diff") and now.get("diff") and before["diff"] != now["diff"]:
        yield "other uncommitted changes"


# the machine


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _blas() -> list[dict[str, Any]]:
    found = {
        (each["internal_api"], each["version"], each["num_threads"])
        for each in threadpool_info()
        if each["user_api"] == "blas"
    }
    return [
        {"library": library, "version": version, "threads": threads}
        for library, version, threads in sorted(found, key=str)
    ]


# the packages


def _packages(modules: Iterable[str]) -> dict[str, str]:
    """Return the versions of what is installed of ``PACKAGES``, the modules' distributions and what those need."""
    names = list(PACKAGES)
    for module in modules:
        names += [each for name in _distributions(module) for each in (name, *_requirements(name, _extras(module)))]
    found = {}
    for name in names:
        with suppress(PackageNotFoundError):
            package = distribution(name)
            found[str(package.name)] = str(package.version)
    return found


def _plugins() -> Iterator[tuple[str, EntryPoint]]:
    """Yield the group and the entry point of all that makes trials."""
    for group in ("optimizers", "problems"):
        yield from ((group, entry) for entry in registry.entries(group).values())


def _distributions(module: str) -> list[str]:
    """Return the names of the distributions that a module comes from, none for a file that nobody installed."""
    top = module.partition(".")[0]
    own = {entry.dist.name for _, entry in _plugins() if entry.dist and entry.module.partition(".")[0] == top}
    if not own and (file := _file(module)) and _is_installed(file):
        own = {*packages_distributions().get(top, ())}
    return sorted(own)


def _extras(module: str) -> set[str]:
    """Return the optional extras that the families of a module need."""
    extras = set()
    for group, entry in _plugins():
        if entry.module == module:
            with suppress(BenchError):  # its trials say what is wrong
                extras.add(str(getattr(registry.load(group, entry.name), "extra", "")))
    return extras


def _requirements(name: str, extras: set[str]) -> list[str]:
    """Return what a distribution needs for these extras; of a stranger's, also what it always needs."""
    wanted = extras - {""} if name == registry.DISTRIBUTION else extras | {""}
    found = []
    for text in distribution(name).requires or ():
        package, extra = re.match(r"[\w.-]+", text), re.search(r"""\bextra\s*==\s*['"]([^'"]+)""", text)
        if package and (extra[1] if extra else "") in wanted:
            found.append(package[0])
    return found


# the code


def _checkouts(modules: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the state of the modules' checkouts, but for the harness's own."""
    homes: dict[Path, str] = {}
    for module in modules:
        if (file := _file(module)) and (home := _home(file)) and home != _home(Path(__file__).resolve()):
            homes.setdefault(home, next(iter(_distributions(module)), printable(home.name, LONGEST)))
    states = zip(unique(homes.values()), map(_git, homes), strict=True)
    return {name: state for name, state in states if state}


def _file(module: str) -> Path | None:
    """Return where a module comes from."""
    with suppress(Exception):  # a stranger's package may raise anything
        spec = find_spec(module)
        return Path(spec.origin).resolve() if spec and spec.has_location and spec.origin else None
    return None


def _is_installed(file: Path) -> bool:
    return any(part in SITES for part in file.parts)


def _home(file: Path) -> Path | None:
    """Return the checkout that a file is part of."""
    with suppress(OSError):
        return None if _is_installed(file) else next((up for up in file.parents if (up / ".git").exists()), None)
    return None


def _git_of(file: Path) -> dict[str, Any] | None:
    home = _home(file)
    return _git(home) if home else None


@cache
def _git(home: Path) -> dict[str, Any] | None:
    """Return commit and uncommitted changes of a checkout, None where git cannot tell.

    ``diff`` is a SHA-256 of the names and contents of all files that differ from the commit or are code that git does
    not know, and None where there are none: unlike a patch, it depends on no setting and no version of git.
    """
    commit = _ask_git(home, "rev-parse", "HEAD")
    changed = _ask_git(home, "diff", "HEAD", "--name-only", "--no-renames", "--no-ext-diff", "-z")
    unknown = _ask_git(home, "ls-files", "--others", "--exclude-standard", "-z")
    if commit is None or changed is None or unknown is None:
        return None
    new = [name for name in map(os.fsdecode, unknown.split(b"\0")) if _is_code(name)]
    names = sorted({*filter(None, map(os.fsdecode, changed.split(b"\0"))), *new})
    digest = hashlib.sha256()
    for name in names:
        digest.update(os.fsencode(name) + b"\0" + _content(home / name))
    return {"commit": commit.decode().strip(), "dirty": bool(names), "diff": digest.hexdigest() if names else None}


def _is_code(name: str) -> bool:
    """Return whether a file that git does not know may change what runs; kept bytecode follows its source."""
    return name.endswith(SOURCES) and "__pycache__" not in name.split("/")


def _content(path: Path) -> bytes:
    """Return the hash of a file's content, of nothing where it was deleted."""
    with suppress(OSError), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
    return bytes(32)


def _ask_git(home: Path, *arguments: str) -> bytes | None:
    """Return what git answers, None where it is missing, fails or never ends."""
    plain = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}  # a hook's say another home
    try:
        return subprocess.run(
            ["git", "-C", home, "-c", "core.fsmonitor=false", *arguments],
            stdin=subprocess.DEVNULL, capture_output=True, check=True, timeout=60,
            env=plain | {"GIT_OPTIONAL_LOCKS": "0"},
        ).stdout  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
