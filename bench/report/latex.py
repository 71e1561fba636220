"""Write tables as LaTeX that compiles for any text in them, and fits the width of a text of one column or of two."""

from __future__ import annotations

import re
import string
import tomllib
import unicodedata
from collections.abc import Iterable, Sequence
from importlib.resources import files
from itertools import pairwise, product
from math import ceil
from typing import NamedTuple

from bench.helpers.bibtex import ACCENTS, LETTERS
from bench.report.parts import Table, TableCell

CAPTION = 2_000  # characters; TeX first measures a caption on one line, and a longer one exceeds its largest dimension
CELL = 200  # characters of a value or a title, for the same reason
SHRINKS = 1.2  # times the width of the text that a table may have: it shrinks to the width, and can still be read
FLOATS = 12  # tables after which LaTeX sets those that it holds back; it can hold few
SHRUNK = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"


class Layout(NamedTuple):
    """The space that a document leaves for tables.

    Attributes:
        document: the class that it was measured in.
        line: characters of the width of the text in a table's type.
        spans: characters from which a table spans both columns, where a text has two.
        page: lines of a page in that type, a caption of one line included.
        size: the command of that type.
    """

    document: str
    line: int
    spans: float
    page: int
    size: str


ONE_COLUMN = Layout(r"\documentclass{article}", 84, 84, 41, "")
TWO_COLUMNS = Layout(r"\documentclass[conference]{IEEEtran}", 120, 63.8, 64, r"\footnotesize")
LAYOUTS = {1: ONE_COLUMN, 2: TWO_COLUMNS}
"""The layouts that tables are written for, by their columns; those of one also compile in an article of two."""


class _Column(NamedTuple):
    """A column of a table: its place, title, whether it holds numbers, and about its width in characters."""

    place: int
    title: str
    numeric: bool
    width: int


def _symbols() -> dict[str, str]:
    tables = tomllib.loads((files("bench.report") / "characters.toml").read_text(encoding="utf-8"))
    math = {sign: f"${command}$" for sign, command in tables["math"].items()}
    return {**LETTERS, **tables["ascii"], **tables["punctuation"], **math}


SYMBOLS = _symbols()
"""The characters that LaTeX needs as commands, which every installation knows in every font encoding."""

_TOKEN = re.compile("[A-Za-z][\u0300-\u036f]+|-+|.")
_MINUS = re.compile(r"(?<![\w.)-])-(?=\d)")
_POWER = re.compile(r"(?<![\w.=])(\d[\d.]*)e([+-]\d+)(?![\w.])|(?<=\])\^d\b")  # 1e-08, [-5, 5]^d
_BREAK = re.compile(r"(?<=[A-Za-z]{2})([:/_.])(?=[A-Za-z]{2})")


def escape(text: str) -> str:
    """Return plain text as one line of LaTeX in pure ASCII.

    The result needs no package and compiles with pdfTeX, XeTeX and LuaTeX in any font encoding. A character that the
    usual fonts lack is written as its code point, like ``[U+65E5]``.
    """
    composed = unicodedata.normalize("NFC", re.sub(r"\s+", " ", text))
    return _TOKEN.sub(lambda token: _latex(token[0]), "".join(map(_decompose, composed)))


def prose(text: str) -> str:
    r"""Return sentences as LaTeX, with powers as in :func:`notation`; names may break after a colon, dot or slash."""
    pieces = _BREAK.split(text)
    pieces[1::2] = [f"{escape(sign)}\\allowbreak{{}}" for sign in pieces[1::2]]
    pieces[::2] = map(notation, pieces[::2])
    return "".join(pieces)


def notation(text: str) -> str:
    r"""Return plain text as :func:`escape` does, with minus signs of numbers, and powers in place of exponents."""
    plain, found, start = _MINUS.sub("−", text), [], 0
    for power in _POWER.finditer(plain):
        mantissa, exponent = power[1], int(power[2] or 0)
        times = "" if mantissa == "1" else f"{mantissa}$\\times$"
        shown = f"{times}10$^{{{exponent}}}$" if exponent else mantissa or "$^d$"
        found += [escape(plain[start : power.start()]), shown]
        start = power.end()
    return "".join([*found, escape(plain[start:])])


def to_latex(table: Table, label: str, layout: Layout = ONE_COLUMN) -> str:
    r"""Return a table for ``\input``; the comments on its first lines list the packages that it needs, and the class.

    A table that is wider or longer than a page comes in parts, each with the index and some of the columns and rows,
    which have one number. A part that may be wider than the text by little shrinks to its width; one that is wider than
    a column is a ``table*``, which spans both. A value of the first column is shown once where rows repeat it.

    References name it ``tab:<label>``; a character other than a letter, a digit or ``.:_-`` becomes ``-``.
    """
    rows = table.rows
    columns = []
    for place, (title, numeric) in enumerate(table.header):
        longest = max(map(len, [title, *(row[place].text + row[place].mark for row in rows)]))
        columns.append(_Column(place, title, numeric, min(longest, CELL)))
    heads = table.frame.index.nlevels * table.has_index
    beside = (len(table.caption) + len(table.note)) // layout.line + 6  # the rules, the header and a space, too
    most = max(layout.page - beside, layout.page // 2)
    parts = [rows[start : start + most] for start in range(0, len(rows), most)] or [[]]
    pieces = [*product(parts, _sets(columns, heads, layout))]
    lines = [r"% needs \usepackage{booktabs,graphicx}", f"% fits {layout.document}"]
    for number, (some, chosen) in enumerate(pieces):
        if number and number % FLOATS == 0:
            lines.append(r"\clearpage")
        caption = (
            r"\addtocounter{table}{-1}\caption[]{(continued)}" if number else _caption(table.caption, f"tab:{label}")
        )
        note = table.note if number == len(pieces) - 1 else ""
        totals = table.totals if some is parts[-1] else 0
        lines += _float(_tabular(some, chosen, once=heads > 1, totals=totals), caption, note, chosen, layout)
    return "\n".join([*lines, ""])


def _float(tabular: Sequence[str], caption: str, note: str, columns: Sequence[_Column], layout: Layout) -> list[str]:
    """Return the lines of a part of a table with its caption and note."""
    kind = "table*" if _width(columns) > layout.spans else "table"
    small = layout.size or r"\footnotesize"
    below = [rf"\par\smallskip\parbox{{\linewidth}}{{{small} {prose(note)}}}"] if note else []
    begin = [rf"\begin{{{kind}}}[htbp]", rf"\centering{layout.size}", caption, r"\par\smallskip"]
    return [*begin, r"\setlength{\tabcolsep}{4pt}", SHRUNK, *tabular, "}", *below, rf"\end{{{kind}}}"]


def _tabular(rows: Sequence[Sequence[TableCell]], columns: Sequence[_Column], *, once: bool, totals: int) -> list[str]:
    """Return the lines of some rows and columns; ``once`` leaves out a first value that is that of the row before."""
    body = [_row([_cell(row[column.place]) for column in columns]) for row in rows]
    if once:
        same = [False, *(before[0].text == row[0].text for before, row in pairwise(rows))]
        body = [
            f" & {line.partition(' & ')[2]}" if repeated else line for line, repeated in zip(body, same, strict=True)
        ]
    if 0 < totals < len(body):
        body.insert(len(body) - totals, r"\midrule")
    header = _row([notation(_cut(column.title)) for column in columns])
    types = "".join("lr"[column.numeric] for column in columns) or "l"
    ended = [line if line == r"\midrule" else f"{line} \\\\" for line in (header, r"\midrule", *body)]
    return [f"\\begin{{tabular}}{{{types}}}", r"\toprule", *ended, r"\bottomrule", r"\end{tabular}"]


def _caption(text: str, label: str) -> str:
    """Return a caption with its label, cut where it is too long for TeX."""
    caption = prose(text)
    if len(caption) > CAPTION:
        caption = escape(text[: CAPTION // 10] + "…")  # a code point takes ten letters
    return f"\\caption{{{caption}}}\\label{{{re.sub(r'[^A-Za-z0-9.:_-]+', '-', label)}}}"


def _width(columns: Iterable[_Column]) -> int:
    """Return about how many characters wide a table of these columns is, with the space between them."""
    return sum(column.width + 2 for column in columns)


def _sets(columns: Sequence[_Column], heads: int, layout: Layout) -> list[list[_Column]]:
    """Return the columns in sets of about the same size, each after those of the index, that fit the text."""
    index, values = [*columns[:heads]], columns[heads:]
    for number in range(1, len(values) + 1):
        size = ceil(len(values) / number)
        sets = [[*index, *values[start : start + size]] for start in range(0, len(values), size)]
        if max(map(_width, sets)) <= SHRINKS * layout.line:
            return sets
    return [[*index, column] for column in values] or [index]


def _row(cells: Sequence[str]) -> str:
    r"""Return a row of the table, without its end, that starts unlike an optional argument of ``\\`` or a rule."""
    text = " & ".join(cells)
    return ("{}" if text[:1] in ("[", "*") else "") + text


def _cell(cell: TableCell) -> str:
    text = notation(_cut(cell.text))
    text = f"\\textit{{{text}}}" if cell.italic else text
    if cell.bold:
        text = f"\\textbf{{\\boldmath {text}}}" if "$" in text else f"\\textbf{{{text}}}"
    text = f"{SYMBOLS['✗']} {text}" if cell.lost else text
    return f"{text}\\textsuperscript{{{escape(cell.mark)}}}" if cell.mark else text


def _cut(text: str) -> str:
    return text if len(text) <= CELL else f"{text[: CELL // 10]}…"  # a code point takes ten letters


def _latex(token: str) -> str:
    """Return one token as LaTeX: a character, a letter with combining marks, or hyphens that do not form a dash."""
    if token[0] == "-":
        return "{}".join(token)
    letter, marks = token[0], token[1:]
    shown = SYMBOLS.get(letter) or (letter if " " <= letter <= "~" else _code(letter))
    for number, mark in enumerate(marks):  # TeX limits the nesting of groups, and no letter has more than two marks
        shown = f"{ACCENTS[mark]}{{{shown}}}" if mark in ACCENTS and number < 2 else shown + _code(mark)
    return shown


def _decompose(character: str) -> str:
    """Return a Latin letter and its marks apart; characters of other scripts stay composed."""
    parts = unicodedata.normalize("NFD", character)
    return parts if parts[0] in string.ascii_letters else character


def _code(character: str) -> str:
    return f"[U+{ord(character):04X}]"
