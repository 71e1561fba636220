"""Sentences that cite works, written as plain text, for pandoc and for LaTeX."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from bench.bibtex import Work
from bench.report.latex import escape


@dataclass(frozen=True)
class Cite:
    """A citation of one or more works within a sentence, by their keys."""

    keys: tuple[str, ...]


Sentence = list[str | Cite]


def sentence(template: str, **values: str | Sentence) -> Sentence:
    """Return a sentence from a template, in which ``{name}`` stands for a value and ``[@key; @key]`` cites works.

    A value is never read as a template: labels are data.
    """
    pieces: Sentence = []
    for part in re.split(r"( \[@[^]]+\]|\{\w+\})", template):
        value: str | Sentence = part
        if part.startswith(" [@"):
            value = [Cite(tuple(part[3:-1].split("; @")))]
        elif part.startswith("{"):
            value = values[part[1:-1]]
        pieces += [value] if isinstance(value, str) else value
    return pieces


def series(items: Sequence[Sentence]) -> Sentence:
    """Return the items joined by commas and a final "and"."""
    joined: Sentence = []
    for number, item in enumerate(items):
        joined += ["" if number == 0 else " and " if number == len(items) - 1 else ", ", *item]
    return joined


def cited_keys(paragraphs: Iterable[Iterable[Sentence]]) -> list[str]:
    """Return the keys that the paragraphs cite, in alphabetical order."""
    pieces = (piece for paragraph in paragraphs for each in paragraph for piece in each)
    return sorted({key for piece in pieces if isinstance(piece, Cite) for key in piece.keys})


@dataclass(frozen=True)
class Style:
    """A way to write sentences: how plain text is escaped and how one or more works are cited."""

    plain: Callable[[str], str]
    cite: Callable[[list[Work]], str]

    def write(self, paragraph: Iterable[Sentence], works: Mapping[str, Work]) -> str:
        """Return a paragraph as text; ``works`` are those it may cite, by key."""
        return " ".join("".join(self._write(piece, works) for piece in each) for each in paragraph)

    def _write(self, piece: str | Cite, works: Mapping[str, Work]) -> str:
        if isinstance(piece, str):
            return self.plain(piece)
        return self.cite([works[key] for key in piece.keys]) if piece.keys else ""


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def _escape_markdown(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>#@~^$|&\"'])", r"\\\1", _one_line(text))


TEXT = Style(_one_line, lambda works: f" ({'; '.join(work.author_year for work in works)})")
MARKDOWN = Style(_escape_markdown, lambda works: f" [{'; '.join(f'@{work.key}' for work in works)}]")
LATEX = Style(escape, lambda works: f"~\\cite{{{','.join(work.key for work in works)}}}")
