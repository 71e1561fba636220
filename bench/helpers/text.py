"""Turn names, which may contain anything, into file names, unique names, printable text and tables of HTML."""

from __future__ import annotations

import hashlib
import html
import json
import re
from collections.abc import Container, Iterable, Sequence


def file_name(name: str) -> str:
    """Return a file name without extension: the letters, digits, ``_`` and ``-`` of ``name``.

    A name that had to be changed ends in a hash, so that two names never share a file.
    """
    safe = slug(name)
    return safe if safe and safe == name else f"{safe or 'part'}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def slug(name: str) -> str:
    """Return the letters, digits and ``_`` of a name in lower case, joined by ``-``; "" where it has none."""
    return re.sub(r"[^a-z0-9_]+", "-", name.lower()).strip("-")[:60]


def short_hash(content: bytes | str) -> str:
    """Return the first 16 hexadecimal digits of the SHA-256 of bytes, or of a text as UTF-8."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()[:16]


def free(name: str, taken: Container[str]) -> str:
    """Return the name, numbered from 2 on where it is taken."""
    candidate, number = name, 1
    while candidate in taken:
        number += 1
        candidate = f"{name}-{number}"
    return candidate


def unique(names: Iterable[str]) -> list[str]:
    """Return the names in their order, numbered from 2 on where an equal one came before."""
    taken: dict[str, None] = {}
    for name in names:
        taken[free(name, taken)] = None
    return list(taken)


def printable(text: str, limit: int) -> str:
    """Return a text without control characters other than line breaks, cut to ``limit`` characters.

    Marks that change the direction of text and invisible marks are replaced too.
    """
    cut = (text if len(text) <= limit else f"{text[:limit]}…").replace("\t", " ")
    return "".join(c if c.isprintable() or c == "\n" else "\N{REPLACEMENT CHARACTER}" for c in cut)


def is_formula(text: str) -> bool:
    """Return whether a spreadsheet would compute a text of a CSV file: "-restart" it would not, "-SUM(1)" it would."""
    return text.startswith("=") or bool(re.match(r"[+@-].*(\||\w\()", text))


def said(value: object) -> str:
    """Return a plug-in's value as the text that its own code makes; if that raises, the name of its type."""
    try:
        return str(value)
    except Exception:
        return f"<{type(value).__name__}>"


def option(value: object) -> str:
    """Return the value of a plug-in's option as text: a text as it is, others as JSON where they have such a form."""
    return value if isinstance(value, str) else json.dumps(value, default=str)


def count(number: int, noun: str, plural: str = "") -> str:
    """Return ``"1 trial"``, ``"2 trials"`` or ``"60,000 trials"``; ``plural`` is needed where it does not end in -s."""
    return f"{number:,} {noun if number == 1 else plural or noun + 's'}"


def html_table(caption: str, rows: Iterable[Sequence[object]], heads: Sequence[str] = ()) -> str:
    """Return a small table for a notebook; all texts are escaped, and colours are left to the notebook's theme.

    The first cell of a row is its head.
    """

    def cell(tag: str, text: object, scope: str = "") -> str:
        return f'<{tag}{scope} style="text-align: left">{html.escape(str(text))}</{tag}>'

    columns = "".join(cell("th", head, ' scope="col"') for head in heads)
    head = f"<thead><tr>{columns}</tr></thead>" if heads else ""
    lines = []
    for first, *others in rows:
        cells = [cell("th", first, ' scope="row"'), *(cell("td", text) for text in others)]
        lines.append(f"<tr>{''.join(cells)}</tr>")
    title = f'<caption style="text-align: left; caption-side: top">{html.escape(caption)}</caption>'
    return f"<table>{title}{head}<tbody>{''.join(lines)}</tbody></table>"


def joined(parts: Sequence[str]) -> str:
    """Return the parts with commas between them, and "and" before the last one."""
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def listing(items: Sequence[str], at_most: int = 8) -> str:
    """Return ``"a, b and c"``, shortened to ``"a, b and 5 more"`` beyond ``at_most``."""
    more = [f"{len(items) - at_most + 1} more"] if len(items) > at_most else []
    return joined([*items[: at_most - len(more)], *more])


def listed(names: Sequence[str], most: int = 5, between: str = ", ") -> str:
    """Return the names with commas between them, shortened to the first ones and the number of the others."""
    more = f" and {len(names) - most:,} more" if len(names) > most else ""
    return between.join(names[:most]) + more
