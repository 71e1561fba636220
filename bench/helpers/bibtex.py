"""Read works from BibTeX, and name them by author and year."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import cache
from inspect import cleandoc
from pathlib import Path

from bench.helpers.errors import BenchError

LETTERS = {
    "ß": r"\ss{}", "æ": r"\ae{}", "Æ": r"\AE{}", "œ": r"\oe{}", "Œ": r"\OE{}", "ø": r"\o{}", "Ø": r"\O{}",
    "ł": r"\l{}", "Ł": r"\L{}", "ı": r"\i{}",
}  # fmt: skip

ACCENTS = {
    "\u0300": r"\`", "\u0301": r"\'", "\u0302": r"\^", "\u0303": r"\~", "\u0304": r"\=", "\u0306": r"\u",
    "\u0307": r"\.", "\u0308": r"\"", "\u030a": r"\r", "\u030b": r"\H", "\u030c": r"\v", "\u0323": r"\d",
    "\u0327": r"\c", "\u0331": r"\b",
}  # fmt: skip
"""Combining marks that every font encoding has (the ogonek, for example, is missing)."""

_SAFE = """
ss ae AE oe OE o O l L i j aa AA u v H c d b r k t th TH dh DH
emph textit textbf textsc textsf texttt textrm textup textsuperscript textsubscript enquote url doi
em it bf sc sl tt rm slash dots ldots textendash textemdash textquoteright textregistered texttrademark TeX LaTeX
mathrm mathbf mathcal mathbb ensuremath sqrt frac sum prod int times cdot ell infty le leq ge geq in to pm approx sim
alpha beta gamma delta epsilon varepsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau phi varphi chi psi omega
Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega
"""
SAFE = frozenset(_SAFE.split())
"""The commands of letters, fonts and formulas that entries may have. Others read, write or run files when a paper that
cites the entry is typeset (\\input, \\openout, \\write18), or change the meaning of what follows (\\catcode, \\def)."""

_COMMAND = re.compile(r"\\([A-Za-z]+|.)|\^\^", re.DOTALL)
_ENTRY = re.compile(r"@([A-Za-z]+)\s*\{")
_KEY = re.compile(r"\s*([A-Za-z0-9][A-Za-z0-9.:_+/-]*)\s*,")
_ACCENT = re.compile(r"""\\(?:([`'^"~=.])|([uvHcdbr])(?=[\s{]))\s*\{?\\?([A-Za-z])\}?""")
_NO_ENTRIES = ("comment", "preamble", "string")


@dataclass(frozen=True)
class Work:
    """A BibTeX entry: its citation key, its type, such as ``article``, and the text of its fields as written."""

    key: str
    kind: str
    fields: str

    @property
    def bibtex(self) -> str:
        """The entry as BibTeX."""
        return f"@{self.kind}{{{self.key},\n  {self.fields}\n}}"

    @property
    def author_year(self) -> str:
        """The work as cited in a text: ``"Holm, 1979"``, with two authors or with ``"et al."``."""
        authors = re.split(r"\s+and\s+", self._field("author") or self._field("editor") or self.key)
        names = [_family_name(author) for author in authors]
        joined = f"{names[0]} et al." if len(names) > 2 or names[1:] == ["others"] else " and ".join(names)
        return f"{joined}, {_plain(self._field('year')) or 'no year'}"

    def is_same(self, other: Work) -> bool:
        """Return whether both entries are equal except for line breaks and indentation."""
        return [self.key, self.kind, *self.fields.split()] == [other.key, other.kind, *other.fields.split()]

    @property
    def title(self) -> str:
        """The work's title as a text, "" where the entry has none."""
        return _plain(self._field("title"))

    @property
    def doi(self) -> str:
        """The work's DOI, "" where the entry has none."""
        return self._field("doi").strip()

    def _field(self, name: str) -> str:
        """Return a field's value without its delimiters, "" where the entry has none."""
        match = re.search(rf"(?:^|[\s,]){name}\s*=\s*([{{\"]?)", self.fields, re.IGNORECASE)
        if not match:
            return ""
        if match[1] == "{":
            return self.fields[match.end() : _closing(self.fields, match.end()) - 1]
        return re.split(r'"' if match[1] else r"[,\s]", self.fields[match.end() :], maxsplit=1)[0]


@cache
def read(file: Path) -> dict[str, Work]:
    """Return the works of a BibTeX file by key; raises BenchError as :func:`parse`."""
    return {work.key: work for work in parse(file.read_text(encoding="utf-8"))}


def parse(bibtex: str) -> list[Work]:
    """Return the entries of a BibTeX text.

    Text between the entries is a comment, as in BibTeX; macros (``@string``) are not read.

    Raises:
        BenchError: for a text without entries, and for an entry with unbalanced braces or without a key of ASCII
            letters, digits and ``.:_+/-``, or with a command of TeX that is not :data:`SAFE`.
    """
    works, start, bibtex = [], 0, cleandoc(bibtex)
    while entry := _ENTRY.search(bibtex, start):
        start = _closing(bibtex, entry.end())
        if entry[1].lower() in _NO_ENTRIES:
            continue
        body = bibtex[entry.end() : start - 1]
        if not (key := _KEY.match(body)):
            raise BenchError(f"a BibTeX entry needs a plain key and a comma after it: {entry[0]}{body[:40]!r}")
        commands = [found for found in _COMMAND.finditer(body) if found[1] is None or found[1].isalpha()]
        if unknown := next((found[0] for found in commands if found[1] not in SAFE), ""):  # None: ^^ is a backslash
            raise BenchError(f"the BibTeX entry {key[1]!r} has {unknown[:40]!r}, TeX that no reference needs")
        works.append(Work(key[1], entry[1], body[key.end() :].strip()))
    if not works and bibtex.strip():
        raise BenchError(f"a BibTeX text holds no entry: {bibtex.strip()[:40]!r}")
    return works


def _closing(text: str, start: int) -> int:
    """Return the position after the brace that closes the one before ``start``; raises BenchError where none does."""
    depth = 1
    for brace in re.finditer(r"[{}]", text[start:]):
        depth += 1 if brace[0] == "{" else -1
        if depth == 0:
            return start + brace.end()
    raise BenchError(f"a BibTeX entry has unbalanced braces: {text[max(start - 20, 0) : start + 20]!r}")


def _family_name(author: str) -> str:
    """Return the family name of ``Family, Jr., Given`` or ``Given von Family``, with its particles."""
    if "," in author:
        return _plain(author.split(",")[0])
    words = re.findall(r"(?:\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}|[^\s{}])+", author)
    particles = [i for i, word in enumerate(words[:-1]) if word[0].islower()]
    return _plain(" ".join(words[particles[0] if particles else -1 :]))


def _plain(tex: str) -> str:
    """Return the TeX of a field as plain text, with accented letters."""
    marks = {command[1:]: mark for mark, command in ACCENTS.items()}
    text = _ACCENT.sub(lambda accent: accent[3] + marks[accent[1] or accent[2]], tex)
    for letter, command in LETTERS.items():
        text = re.sub(re.escape(command[:-2]) + r"(?![A-Za-z])\s*", letter, text)
    text = re.sub(r"\\([&%$#_])", r"\1", text).replace("~", " ")
    return unicodedata.normalize("NFC", " ".join(re.sub(r"[{}]", "", text).split()))
