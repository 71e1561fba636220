"""The sentence of a methods section on software and machines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from bench.report.prose import Cite, Sentence, sentence, series
from bench.report.wording import listing

NEUTRAL = ("joblib", "matplotlib", "pandas", "seaborn")
"""Packages on which no trial's result depends: they schedule trials, keep tables and draw."""


def software(environments: Sequence[Mapping[str, Any]]) -> Iterator[Sentence]:
    """Yield a sentence on the versions, commits and processors that made the trials, none where none is recorded."""
    versions: dict[str, list[str]] = {}
    for environment in environments:
        for name, version in {"Python": environment.get("python"), **(environment.get("packages") or {})}.items():
            if version and name not in NEUTRAL:
                versions[name] = _distinct([*versions.get(name, []), str(version)])
    if not versions:
        return
    works = {"numpy": [Cite(("harris2020",))], "scipy": [Cite(("virtanen2020",))]}
    packages: list[Sentence] = [
        [f"{name} {' and '.join(found)}", *works.get(name, [])] for name, found in versions.items()
    ]
    processors = _distinct(environment.get("processor") for environment in environments)
    states: dict[str, list[Mapping[str, Any]]] = {}
    for environment in environments:
        for name, git in {"source code": environment.get("git"), **(environment.get("checkouts") or {})}.items():
            states.setdefault(name, []).extend([git] if git else [])
    code = [text for name, found in states.items() if (text := _commits(name, found))]
    yield sentence(
        "The trials used {packages}{source}{machine}.",
        packages=series(packages),
        source=f" ({'; '.join(code)})" if code else "",
        machine=f" on {listing(processors)}" if processors else "",
    )


def _commits(name: str, states: Sequence[Mapping[str, Any]]) -> str:
    """Return the commits of a checkout, "" where none is recorded."""
    commits = _distinct(str(state.get("commit") or "")[:10] for state in states)
    changed = ", with local changes" if any(state.get("dirty") for state in states) else ""
    return f"{name} at commit {listing(commits)}{changed}" if commits else ""


def _distinct(values: Iterable[Any]) -> list[str]:
    return list(dict.fromkeys(value for value in values if value))
