"""Fill templates of prose that cites works, and write it as plain text, for pandoc and for LaTeX."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from bench.bibtex import Work
from bench.report.latex import escape

_CITATION = re.compile(r" \[@([^]]+)\]")


@cache
def templates() -> Environment:
    """Return the templates of prose; ``[@key; @key]`` after a space in their text cites works."""
    return Environment(
        loader=PackageLoader("bench.report", ""),
        undefined=StrictUndefined,
        finalize=_data,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _data(value: Any) -> str:
    """Return a value for a template such that no part of it reads as a citation or ends the paragraph."""
    return value if isinstance(value, Markup) else _one_line(str(value)).replace("[", "[[")


def paragraphs(filled: str) -> list[str]:
    """Return the paragraphs of a filled template, each as one line; blank lines separate them."""
    return [" ".join(each.split()) for each in re.split(r"\n\s*\n", filled) if each.strip()]


def cited_keys(prose: Sequence[str]) -> list[str]:
    """Return the keys that the paragraphs cite, in alphabetical order."""
    return sorted({key for each in prose for keys in _CITATION.findall(each) for key in keys.split("; @")})


@dataclass(frozen=True)
class Style:
    """A way to write prose: how plain text is escaped and how one or more works are cited."""

    plain: Callable[[str], str]
    cite: Callable[[list[Work]], str]

    def write(self, prose: str, works: Mapping[str, Work]) -> str:
        """Return a paragraph of a filled template; ``works`` are those it may cite, by key."""
        pieces = _CITATION.split(prose)  # every second piece holds keys
        pieces[::2] = [self.plain(piece.replace("[[", "[")) for piece in pieces[::2]]
        pieces[1::2] = [self.cite([works[key] for key in keys.split("; @")]) for keys in pieces[1::2]]
        return "".join(pieces)


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def _escape_markdown(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>#@~^$|&\"'])", r"\\\1", _one_line(text))


TEXT = Style(str, lambda works: f" ({'; '.join(work.author_year for work in works)})")
MARKDOWN = Style(_escape_markdown, lambda works: f" [{'; '.join(f'@{work.key}' for work in works)}]")
LATEX = Style(escape, lambda works: f"~\\cite{{{','.join(work.key for work in works)}}}")
