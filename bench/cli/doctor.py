"""bench doctor: print what this installation is, what is broken in it and how to fix it, for a bug report."""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from bench.cli import completion
from bench.cli.console import table
from bench.errors import BenchError
from bench.helpers.console import print_line
from bench.plugins import registry

GROUPS = ("optimizers", "problems", "commands", "studies", "report_sections")
STYLES = {"ok": "green", "note": "yellow", "broken": "red"}


@dataclass(frozen=True)
class Finding:
    """A finding on one thing: ``state`` is "ok", "note" (something is missing that may be) or "broken"."""

    topic: str
    name: str
    found: str
    state: str = "ok"
    remedy: str = ""


def command(
    folder: Annotated[
        Path | None,
        typer.Argument(help="A folder that 'bench run' wrote, to check its store.", autocompletion=completion.folders),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Check this installation, and print what a bug report needs: versions, extras, machine, caches and plug-ins.

    The exit code is 1 where something is broken; how to fix it stands beside it.
    """
    findings = list(examine(folder))
    broken = [finding for finding in findings if finding.state == "broken"]
    if as_json:
        print(json.dumps({"sound": not broken, "findings": [asdict(finding) for finding in findings]}, indent=1))
    else:
        _show(findings, Console())
    if broken:
        sys.exit(1)


def examine(folder: Path | None = None) -> Iterator[Finding]:
    """Yield the findings on the program, its requirements, the machine, and the store of a study's folder."""
    for part in (_program, _names, _requirements, _machine, _plugins, _caches, _sandbox):
        try:
            yield from part()
        except ImportError as error:  # what is broken must not hide what else is
            remedy = f"pip install --force-reinstall {registry.DISTRIBUTION}"
            yield Finding("packages", error.name or "unknown", f"cannot be imported: {error}", "broken", remedy)
    if folder is not None:
        yield from _store(folder)


def _show(findings: list[Finding], console: Console) -> None:
    rows, last = [], ""
    for finding in findings:
        topic = Text(finding.topic if finding.topic != last else "", "bold")
        rows.append((topic, finding.name, finding.found, Text(finding.state, STYLES[finding.state])))
        last = finding.topic
    console.print(table(("", "what", "found", "state"), rows))
    extras = [finding.name for finding in findings if finding.topic == "extras" and finding.state == "note"]
    lines = [
        (finding.state, f"{finding.state}: {finding.topic}, {finding.name}: {finding.remedy}")
        for finding in findings
        if finding.remedy and finding.name not in (extras if finding.topic == "extras" else ())
    ]
    if extras:  # in one line, as the table has each
        install = f"pip install '{registry.DISTRIBUTION}[{','.join(extras)}]'"
        lines.insert(0, ("note", f"note: extras that are not installed: {install}"))
    broken = sum(finding.state == "broken" for finding in findings)
    lines.append(("broken", f"{broken} broken") if broken else ("ok", "nothing is broken"))
    for state, line in lines:
        print_line(line, STYLES[state], console)


# The installation


def _program() -> Iterator[Finding]:
    try:
        package = registry.own()
    except BenchError as error:
        yield Finding("program", registry.DISTRIBUTION, "not installed", "broken", str(error))
        return
    yield Finding("program", registry.DISTRIBUTION, f"{package.version} in {Path(__file__).resolve().parents[2]}")
    running = ".".join(map(str, sys.version_info[:3]))
    needed = str(package.metadata["Requires-Python"])
    yield _bounded("program", "Python", f"{running} ({sys.executable})", running, needed, f"install Python {needed}")


def _names() -> Iterator[Finding]:
    """Yield whether the top-level modules, which have common names, are those of this distribution."""
    with suppress(BenchError):
        for module in registry.own_modules():
            if sentence := registry.conflict(module):
                yield Finding("names", module, "another package's", "broken", sentence)
            elif packages := " and ".join(registry.claimants(module)):
                clash = (
                    f"this package's; {packages} has a module of that name, too, whose file is not installed any more"
                )
                remedy = f"install {packages} in an environment of its own, as one of the two breaks the other"
                yield Finding("names", module, clash, "note", remedy)
            else:
                yield Finding("names", module, "this package's")


def _requirements() -> Iterator[Finding]:
    """Yield the versions of the packages that are needed, and by extra of those that are optional."""
    from packaging.requirements import Requirement

    with suppress(BenchError):
        optional = []
        for requirement in map(Requirement, registry.own().requires or ()):
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                yield _required(requirement, registry.DISTRIBUTION)
            else:
                optional.append(requirement)
        for extra in sorted(registry.own().metadata.get_all("Provides-Extra") or ()):
            yield _extra(
                extra, [needed for needed in optional if needed.marker and needed.marker.evaluate({"extra": extra})]
            )


def _required(requirement: Any, asked: str) -> Finding:
    install = f"pip install '{asked}'"
    try:
        installed = version(requirement.name)
    except PackageNotFoundError:
        return Finding("packages", requirement.name, "not installed", "broken", install)
    return _bounded("packages", requirement.name, installed, installed, str(requirement.specifier), install)


def _extra(extra: str, requirements: list[Any]) -> Finding:
    """Return one finding on an extra: a package that is missing is no fault, one of a wrong version is."""
    asked = f"{registry.DISTRIBUTION}[{extra}]"
    packages = [_required(requirement, asked) for requirement in requirements]
    missing = [package.name for package in packages if package.found == "not installed"]
    text = ", ".join(f"{package.name} {package.found}" for package in packages)
    if any(package.state == "broken" and package.name not in missing for package in packages):
        return Finding("extras", extra, text, "broken", f"pip install '{asked}'")
    if missing:
        return Finding("extras", extra, f"without {', '.join(missing)}", "note", f"pip install '{asked}'")
    return Finding("extras", extra, text)


def _bounded(topic: str, name: str, shown: str, installed: str, bounds: str, remedy: str) -> Finding:
    """Return a finding on a version that must be within bounds such as ``">=2.0,<3"``."""
    from packaging.specifiers import SpecifierSet

    if SpecifierSet(bounds).contains(installed, prereleases=True):
        return Finding(topic, name, shown)
    return Finding(topic, name, f"{shown}; needed is {bounds}", "broken", remedy)


def _plugins() -> Iterator[Finding]:
    """Yield the number of plug-ins of each group, and every one that does not load."""
    for group in GROUPS:
        try:
            names = sorted(registry.entries(group))
        except BenchError as error:
            yield Finding("plug-ins", group, "not found", "broken", str(error))
            return  # all groups share the cause
        failed = 0
        for name in names:
            try:
                registry.load(group, name)
            except BenchError as error:
                failed += 1
                who = registry.package(group, name) or "its package"
                yield Finding("plug-ins", name, str(error), "broken", f"update or uninstall {who}")
        yield Finding("plug-ins", group, f"{len(names) - failed} of {len(names)} load")


# The machine


def _machine() -> Iterator[Finding]:
    """Yield the machine's cores, memory and BLAS, whose threads compete with the worker processes of a run."""
    import scipy.linalg  # noqa: F401 - loads the BLAS

    from bench.storage import provenance

    try:
        record = provenance.machine()
    except BenchError:  # on plug-ins, which have findings of their own
        return
    for name, key in (("system", "system"), ("processor", "processor"), ("cores", "cores")):
        yield Finding("machine", name, str(record[key]))
    yield Finding("machine", "memory", f"{record['memory_gb']} GB")
    for library in record["blas"]:
        yield Finding("machine", "BLAS", f"{library['library']} {library['version']}, {library['threads']} threads")
    if record["git"]:
        changed = ", with uncommitted changes" if record["git"]["dirty"] else ""
        yield Finding("machine", "commit", f"{record['git']['commit'][:10]}{changed}")


def _caches() -> Iterator[Finding]:
    """Yield whether the folders can be written that hold what need not be computed twice."""
    from platformdirs import user_cache_path

    beside = Path(__file__).resolve().parents[2] / "optimizers" / "__pycache__"  # where numba writes, if it can
    compiled = os.environ.get("NUMBA_CACHE_DIR")
    places = [Path(compiled)] if compiled else [beside, user_cache_path("numba", False)]
    for name, variable, folders in (
        ("compiled code", "NUMBA_CACHE_DIR", places),
        ("temporary files", "TMPDIR", [Path(tempfile.gettempdir())]),
    ):
        if usable := next((folder for folder in folders if _can_write(folder)), None):
            yield Finding("caches", name, str(usable))
        else:
            remedy = f"set {variable} to a folder that can be written"
            yield Finding("caches", name, f"{folders[0]} cannot be written", "broken", remedy)


def _can_write(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _sandbox() -> Iterator[Finding]:
    if program := shutil.which("bwrap"):
        yield Finding("sandbox", "bubblewrap", program)
    else:
        yield Finding("sandbox", "bubblewrap", "not installed", "note", "--untrusted needs it (Linux only)")


def _store(folder: Path) -> Iterator[Finding]:
    """Yield the health of a study's store: every row is compared with its digest."""
    from bench.storage.folder import Folder

    try:
        opened = Folder(folder)
        study, check = opened.study(), opened.check_store()
    except BenchError as error:
        yield Finding("store", str(folder), "cannot be read", "broken", str(error))
        return
    remedy = "" if check.sound else "run 'bench run' with the same study and --output, which makes those trials again"
    text = f"study {study.name}: {check.sentence}"
    yield Finding("store", str(folder), text, "ok" if check.sound else "broken", remedy)
