"""A table as LaTeX that compiles as it is, whatever its text holds."""

from __future__ import annotations

import re
import string
import unicodedata
from collections.abc import Iterable, Sequence

from bench.bibtex import ACCENTS, LETTERS
from bench.report.parts import Table, TableCell

LINE = 84  # characters that a line of an article holds in a table's small type
COLUMN = 42  # of a two-column paper: what may be wider is made to shrink
WRAP = 40  # a column wider than this is set in paragraphs
WORD = 12  # in them, a longer word may break after so many letters
CAPTION = 2_000  # a longer caption, which TeX first measures on one line, exceeds its largest dimension
PAGE = 45  # rows that fit on a page with their caption

SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': "''", "`": r"\`{}",
}  # fmt: skip
"""The characters of ASCII that LaTeX does not show as they are."""

_GREEK = "αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΥΦΨΩ"
_GREEK_NAMES = (
    "alpha beta gamma delta varepsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon varphi chi "
    "psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
_MATH = {
    "−": "-", "±": r"\pm", "×": r"\times", "·": r"\cdot", "÷": r"\div", "∞": r"\infty", "≤": r"\leq", "≥": r"\geq",
    "≠": r"\neq", "≈": r"\approx", "∝": r"\propto", "√": r"\surd", "∑": r"\sum", "∈": r"\in", "→": r"\rightarrow",
    "←": r"\leftarrow", "↑": r"\uparrow", "↓": r"\downarrow", "°": r"^\circ", "µ": r"\mu", "ϵ": r"\epsilon",
    **{letter: f"\\{name}" for letter, name in zip(_GREEK, _GREEK_NAMES.split(), strict=True)},
    **{sign: f"^{digit}" for digit, sign in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")},
    **{sign: f"_{digit}" for digit, sign in enumerate("₀₁₂₃₄₅₆₇₈₉")},
}  # fmt: skip
_PUNCTUATION = {
    "–": "--", "—": "---", "‘": "`", "’": "'", "“": "``", "”": "''", "…": r"\ldots{}", "•": r"\textbullet{}",
    "§": r"\S{}", "©": r"\copyright{}", "€": r"\texteuro{}", "£": r"\pounds{}", "‐": "-", "‑": "-",
}  # fmt: skip
SYMBOLS = SPECIAL | LETTERS | _PUNCTUATION | {sign: f"${command}$" for sign, command in _MATH.items()}

_TOKEN = re.compile("[A-Za-z][\u0300-\u036f]+|-+|.")
_POWER = re.compile(r"(-?[\d.]+)e([+-]\d+)")


def escape(text: str) -> str:
    """Return plain text as LaTeX shows it, on one line, in pure ASCII.

    It needs no package and compiles with pdfTeX, XeTeX and LuaTeX in any font encoding. A character that they cannot
    all show, such as one of a script that the usual fonts lack, is shown as its code point, like ``[U+65E5]``.
    """
    composed = unicodedata.normalize("NFC", re.sub(r"\s+", " ", text))
    return _TOKEN.sub(lambda token: _show(token[0]), "".join(map(_decompose, composed)))


def to_latex(table: Table, label: str) -> str:
    r"""Return a table to be read with ``\input``; the comment on its first line says which packages it needs.

    A table that may be wider than a column shrinks to the line where it must, one that may be wider than a page is
    a ``table*``, which spans both columns where there are two, and columns of long texts are set in paragraphs. A
    table too long for a page is a ``longtable``, which breaks across pages; LaTeX allows it only where the text is in
    one column.

    Args:
        table: what to show; bold and italic cells are set so.
        label: it is referred to as ``tab:<label>``; what is not a letter, a digit or one of ``.:_-`` becomes ``-``.
    """
    titles, numeric = [title for title, _ in table.header], [number for _, number in table.header]
    rows = table.rows
    texts = [titles, *([cell.text for cell in row] for row in rows)]
    widths = [min(max(map(len, column)), 2 * LINE) for column in zip(*texts, strict=True)]
    wrapped = [width > WRAP for width in widths]
    header = _row(_words(title, wrap) for title, wrap in zip(titles, wrapped, strict=True))
    body = [_row(map(_set, row, numeric, wrapped)) for row in rows]
    columns = _columns(widths, numeric, wrapped) or "l"
    safe = re.sub(r"[^A-Za-z0-9.:_-]+", "-", label)
    words = escape(table.caption)
    if len(words) > CAPTION:
        words = escape(table.caption[: CAPTION // 10] + "…")  # a code point takes ten letters
    caption = f"\\caption{{{words}}}\\label{{tab:{safe}}}"
    packages = ["booktabs", *(["array"] if any(wrapped) else [])]
    if len(body) > PAGE:
        packages.append("longtable")
        lines = _long(columns, header, body, caption, escape(table.note))
    else:
        width = sum(widths) + 2 * len(widths)
        packages += ["graphicx"] if width > COLUMN else []
        lines = _float(columns, header, body, caption, escape(table.note), width)
    return "\n".join([f"% needs \\usepackage{{{','.join(packages)}}}", *lines, ""])


def _float(columns: str, header: str, body: Sequence[str], caption: str, note: str, width: int) -> list[str]:
    table, wide = "table*" if width > LINE else "table", width > COLUMN
    shrink = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"  # as it is where it fits
    return [
        f"\\begin{{{table}}}[htbp]",
        r"\centering",
        caption,
        r"\par\smallskip",  # some classes set captions for below
        *([r"\setlength{\tabcolsep}{4pt}", shrink] if wide else []),
        f"\\begin{{tabular}}{{{columns}}}",
        *(r"\toprule", header, r"\midrule", *body, r"\bottomrule"),
        r"\end{tabular}" + ("}" if wide else ""),
        *([f"\\par\\smallskip\\parbox{{\\linewidth}}{{\\footnotesize {note}}}"] if note else []),
        f"\\end{{{table}}}",
    ]


def _long(columns: str, header: str, body: Sequence[str], caption: str, note: str) -> list[str]:
    head = (r"\toprule", header, r"\midrule")
    return [
        r"{\footnotesize\setlength{\tabcolsep}{3pt}",
        f"\\begin{{longtable}}{{{columns}}}",
        caption + r"\\",
        *(*head, r"\endfirsthead", r"\caption[]{(continued)}\\", *head, r"\endhead", r"\bottomrule", r"\endfoot"),
        *body,
        r"\end{longtable}",
        *([f"\\noindent {note}\\par"] if note else []),
        "}",
    ]


def _columns(widths: Sequence[int], numeric: Sequence[bool], wrapped: Sequence[bool]) -> str:
    """Return the column types: numbers right, words left, and paragraphs, which share what the others leave."""
    wants = sum(width for width, wrap in zip(widths, wrapped, strict=True) if wrap)
    taken = sum(width + 2 for width, wrap in zip(widths, wrapped, strict=True) if not wrap)
    room = max(LINE - taken, WRAP * sum(wrapped)) / LINE
    types = []
    for width, number, wrap in zip(widths, numeric, wrapped, strict=True):
        side = "left" if number else "right"  # \raggedleft sets to the right
        paragraph = f">{{\\ragged{side}\\arraybackslash}}p{{{room * width / max(wants, 1):.2f}\\linewidth}}"
        types.append(paragraph if wrap else "lr"[number])
    return "".join(types)


def _row(cells: Iterable[str]) -> str:
    r"""Return a table's row; what follows ``\\`` or a rule must not look like its optional argument."""
    text = " & ".join(cells)
    return ("{}" if text[:1] in ("[", "*") else "") + text + r" \\"


def _set(cell: TableCell, number: bool, wrap: bool) -> str:
    text = _number(cell.text) if number else _words(cell.text, wrap)
    text = f"\\textit{{{text}}}" if cell.italic else text
    if cell.bold:
        text = f"\\textbf{{\\boldmath {text}}}" if "$" in text else f"\\textbf{{{text}}}"
    return f"{text}\\textsuperscript{{{escape(cell.mark)}}}" if cell.mark else text


def _words(text: str, wrap: bool) -> str:
    """Return a text, of which the long words of a paragraph, such as paths and hashes, may break where they must."""
    if not wrap:
        return escape(text)
    pieces = ([word[i : i + WORD] for i in range(0, len(word), WORD)] for word in text.split())
    return " ".join(r"\allowbreak{}".join(map(escape, word)) for word in pieces)


def _number(text: str) -> str:
    """Return a number with a minus sign for the hyphen and a power of ten for the exponent."""
    parts = _POWER.fullmatch(text)
    shown = escape((parts[1] if parts else text).replace("-", "−"))
    return f"{shown}$\\times$10$^{{{int(parts[2])}}}$" if parts else shown


def _show(token: str) -> str:
    """Return one character, a letter with its combining marks, or hyphens that make no dash, as LaTeX."""
    if token[0] == "-":
        return "{}".join(token)
    letter, marks = token[0], token[1:]
    shown = SYMBOLS.get(letter) or (letter if " " <= letter <= "~" else _code(letter))
    for number, mark in enumerate(marks):  # TeX nests only so many groups, and no letter has more than two
        shown = f"{ACCENTS[mark]}{{{shown}}}" if mark in ACCENTS and number < 2 else shown + _code(mark)
    return shown


def _decompose(character: str) -> str:
    """Return a letter with marks taken apart where the letter is plain; other scripts stay composed."""
    parts = unicodedata.normalize("NFD", character)
    return parts if parts[0] in string.ascii_letters else character


def _code(character: str) -> str:
    return f"[U+{ord(character):04X}]"
