"""Write tables and figures as LaTeX that compiles for any text in it."""

from __future__ import annotations

import re
import string
import tomllib
import unicodedata
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from itertools import groupby
from math import ceil, floor
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, Template

from bench.helpers.bibtex import ACCENTS, LETTERS
from bench.plots.style import COLUMN, POINT, SMALL
from bench.report.parts import Figure, Table, TableCell

WRAP = 40  # characters beyond which a column is set in paragraphs
WORD = 12  # letters after which a longer word in such a paragraph may break
CAPTION = 2_000  # characters; TeX first measures a caption on one line, and a longer one exceeds its largest dimension
BLOCK = 10  # rows of a block that is named once, and that no page break divides
TALLEST = 0.8  # of the height of a page that a figure may take beside its caption
SHRUNK = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"


class Layout(NamedTuple):
    """The space that a document leaves for tables and figures.

    Attributes:
        document: the class that it was measured in.
        line: characters of the width of the text in a table's type.
        column: those of a column; a table that may be wider shrinks to fit.
        spans: characters from which a table spans both columns, where a text has two.
        page: lines of a page in that type, a caption of one line included.
        height: inches of the text of a page.
        points: the size of that type.
        size: its command.
        breaks: whether a long table may be a ``longtable``, which two-column classes refuse.
    """

    document: str
    line: int
    column: int
    spans: float
    page: int
    height: float
    points: float
    size: str
    breaks: bool

    @property
    def widest(self) -> float:
        """The lines beyond which a table that shrinks to one would have letters too small to read."""
        return self.points / SMALL


ONE_COLUMN = Layout(r"\documentclass{article}", 84, 42, 84, 41, 550 * POINT, 10.0, "", breaks=True)
TWO_COLUMNS = Layout(
    r"\documentclass[conference]{IEEEtran}", 120, 58, 63.8, 64, 672 * POINT, 8.0, r"\footnotesize", breaks=False
)
LAYOUTS = {1: ONE_COLUMN, 2: TWO_COLUMNS}
"""The layouts that tables are written for, by their columns; those of one also compile in an article of two."""


class _Column(NamedTuple):
    """A column of a table: its place, title, whether it holds numbers, and about its width in characters."""

    place: int
    title: str
    numeric: bool
    width: int

    @property
    def wraps(self) -> bool:
        """Whether its texts are set in paragraphs."""
        return self.width > WRAP


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

    A table that may be wider than a column shrinks to the line width. A table that may be wider than a page, or in a
    text of two columns wider than one of them, is a ``table*``, which spans both. Columns of long texts are set in
    paragraphs. A table longer than a page comes in parts of a page each with one number; in a plain article it is a
    ``longtable``, which breaks across pages; LaTeX allows it only in one-column text. As such a
    table cannot shrink, one without paragraphs that may be wider than a page, too, comes in several of the other kind
    with one number. Of a very wide one the columns are set in sets, one below the other, each beside the index, or, if
    these need more than a page, it is turned. Rows whose first value is that of the row before are a block, which shows
    it once.

    References name it ``tab:<label>``; a character other than a letter, a digit or ``.:_-`` becomes ``-``.
    """
    rows = table.rows
    columns = []
    for place, (title, numeric) in enumerate(table.header):
        longest = max(map(len, [title, *(row[place].text for row in rows)]))
        columns.append(_Column(place, title, numeric, min(longest, 2 * layout.line)))
    wraps = any(column.wraps for column in columns)
    width, line = _width(columns), layout.line
    lines = len(rows) + len(table.caption) // line + len(table.note) // line
    long = lines > layout.page
    breaks = layout.breaks and long and (width <= line or wraps)  # paragraphs fit, and their height is not known
    sets = [columns]
    turned = width > layout.widest * line and not wraps
    if (
        turned
        and len(apart := _sets(columns, table.frame.index.nlevels * table.has_index, layout)) * lines <= layout.page
    ):
        sets, turned = apart, False
    needed = {"array": wraps, "longtable": breaks, "graphicx": width > layout.column and not breaks}
    blocks = _blocks(table, rows)
    most = len(rows) if breaks else _most_rows(table, columns, layout, turned=turned, long=long)
    return _template("table.tex.j2").render(
        document=layout.document,
        size=layout.size,
        shrunk=SHRUNK,
        packages=",".join(["booktabs", *(name for name, need in needed.items() if need)]),
        breaks=breaks,
        small=long and width > 0.75 * line and layout.breaks,
        wide=width > layout.column,
        turned=turned,
        float="table*" if width > layout.spans else "table",
        caption=_caption(table.caption, f"tab:{label}"),
        tabulars=[_tabular(columns_of, blocks, most, line) for columns_of in sets],
        totals=table.totals,
        note=prose(table.note),
    )


def figure_to_latex(figure: Figure, path: str, label: str, layout: Layout = ONE_COLUMN) -> str:
    r"""Return a figure with its caption for ``\input``; ``path`` is that of its PDF, relative to the paper.

    A figure wider than a column is a ``figure*``, which spans both columns where there are two. One that is larger than
    a page shrinks. References name it ``fig:<label>``, as :func:`to_latex` does.
    """
    width, height = figure.figure.get_size_inches()
    return _template("figure.tex.j2").render(
        document=layout.document,
        path=path,
        float="figure*" if width > COLUMN else "figure",
        shrunk=SHRUNK if layout.breaks else "",  # an article is narrower than two columns
        tallest=TALLEST if height > TALLEST * layout.height else "",
        caption=_caption(figure.caption, f"fig:{label}"),
    )


def _caption(text: str, label: str) -> str:
    """Return a caption with its label, cut where it is too long for TeX."""
    caption = prose(text)
    if len(caption) > CAPTION:
        caption = escape(text[: CAPTION // 10] + "…")  # a code point takes ten letters
    return f"\\caption{{{caption}}}\\label{{{re.sub(r'[^A-Za-z0-9.:_-]+', '-', label)}}}"


def _most_rows(table: Table, columns: Sequence[_Column], layout: Layout, *, turned: bool, long: bool) -> int:
    """Return the rows of a table that fit on a page beside its caption and note; a wider one shrinks more.

    A turned table has the width of the text for its rows, and one that shrinks little has as many as the page holds in
    its type. The numbers of a plain article are those of ``article`` in 10 pt, whose page is small, and a note of four
    lines fits there without taking rows.
    """
    width, line = _width(columns), layout.line
    if layout.breaks:
        if not turned and not long:
            return len(table.frame)
        lines = max(len(table.note) // line - 4, 0)
        return max((int(0.28 * width) if turned else min(int(0.73 * width), 75)) - lines, 1)
    beside = len(table.caption) // line + len(table.note) // line + 4  # of a caption that is set larger, and the rules
    if turned:
        return max(int(0.28 * max(width, 2 * line)) * line // 120 - beside, 1)
    paragraphs = [column.width for column in columns if column.wraps]
    height = max(1, -(-sum(paragraphs) // max(line - (width - sum(paragraphs)), WRAP))) if paragraphs else 1
    shrunk = 1.0 if paragraphs else min(max(width / line, 1.0), layout.widest)
    return max(int((layout.page - beside) * shrunk) // height, 1)


def _width(columns: Iterable[_Column]) -> int:
    """Return about how many characters wide a table of these columns is, with the space between them."""
    return sum(column.width + 2 for column in columns)


def _sets(columns: Sequence[_Column], heads: int, layout: Layout) -> list[list[_Column]]:
    """Return the columns in sets of about the same size, each after those of the index, that are not very wide."""
    index, values = columns[:heads], columns[heads:]
    for number in range(1, len(values) + 1):
        size = ceil(len(values) / number)
        sets = [[*index, *values[start : start + size]] for start in range(0, len(values), size)]
        if max(map(_width, sets)) <= layout.widest * layout.line:
            return sets
    return [[*index, column] for column in values]


def _tabular(columns: Sequence[_Column], blocks: list[list[list[TableCell]]], most: int, line: int) -> dict[str, Any]:
    """Return the types, the header and the rows, by part and block, of some columns, for the template."""
    lines = [
        [
            _row([_cell(row[column.place], column) for column in columns], skip=number > 0)
            for number, row in enumerate(block)
        ]
        for block in blocks
    ]
    return {
        "columns": _types(columns, line) or "l",
        "header": _row([_text(column.title, column.wraps) for column in columns]),
        "parts": _parts(lines, most),
    }


def _blocks(table: Table, rows: list[list[TableCell]]) -> list[list[list[TableCell]]]:
    """Return the rows in blocks of the same first value where the index names them by more; else each alone."""
    alone = [[row] for row in rows]
    if not table.has_index or table.frame.index.nlevels < 2:
        return alone
    blocks = [list(block) for _, block in groupby(rows, lambda row: row[0].text)]
    return blocks if max(map(len, blocks), default=0) <= BLOCK else alone


def _parts(blocks: list[list[str]], most: int) -> list[list[list[str]]]:
    """Divide the blocks into the fewest parts of about the same size that hold at most ``most`` rows each.

    A block is never divided, so a part may have more rows by the rest of its last block.
    """
    total = sum(map(len, blocks))
    number = max(-(-total // max(most, 1)), 1)
    parts: list[list[list[str]]] = [[] for _ in range(number)]
    passed = 0
    for block in blocks:
        parts[passed * number // max(total, 1)].append(block)
        passed += len(block)
    return [part for part in parts if part] or [[]]


@cache
def _template(name: str) -> Template:
    environment = Environment(
        loader=PackageLoader("bench.report", ""),
        block_start_string="<%", block_end_string="%>", variable_start_string="<<", variable_end_string=">>",
        comment_start_string="<#", comment_end_string="#>",
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    return environment.get_template(name)


def _types(columns: Sequence[_Column], line: int) -> str:
    """Return the column types: numbers right, texts left, and paragraphs, which share the rest of the width."""
    paragraphs = [column for column in columns if column.wraps]
    wants = sum(column.width for column in paragraphs)
    taken = _width(column for column in columns if not column.wraps)
    room = max(line - taken, WRAP * len(paragraphs)) / line
    types = []
    for column in columns:
        side = "left" if column.numeric else "right"  # \raggedleft sets to the right
        share = floor(100 * room * column.width / max(wants, 1)) / 100
        paragraph = f">{{\\ragged{side}\\arraybackslash}}p{{{share:.2f}\\linewidth}}"
        types.append(paragraph if column.wraps else "lr"[column.numeric])
    return "".join(types)


def _row(cells: Sequence[str], *, skip: bool = False) -> str:
    r"""Return a row of the table, without its end, that does not start like an optional argument of ``\\`` or a rule.

    The first cell is left empty on request.
    """
    text = " & ".join(["", *cells[1:]] if skip else cells)
    return ("{}" if text[:1] in ("[", "*") else "") + text


def _cell(cell: TableCell, column: _Column) -> str:
    text = _text(cell.text, column.wraps)
    text = f"\\textit{{{text}}}" if cell.italic else text
    if cell.bold:
        text = f"\\textbf{{\\boldmath {text}}}" if "$" in text else f"\\textbf{{{text}}}"
    text = f"{SYMBOLS['✗']} {text}" if cell.lost else text
    return f"{text}\\textsuperscript{{{escape(cell.mark)}}}" if cell.mark else text


def _text(text: str, wrap: bool) -> str:
    """Return a text; in a paragraph, long words such as paths and hashes may break."""
    if not wrap:
        return notation(text)
    pieces = ([word[i : i + WORD] for i in range(0, len(word), WORD)] for word in text.split())
    return " ".join(r"\allowbreak{}".join(map(notation, word)) for word in pieces)


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
