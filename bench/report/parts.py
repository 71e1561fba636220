"""The parts of a report: sections of text, tables and figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import matplotlib.figure
import pandas as pd
from pandas.api.types import is_bool_dtype, is_numeric_dtype

from bench.helpers.text import slug
from bench.report.wording import cell_text, usual_decimals

SHADES = 8  # steps of a table's background
MOST_ROWS = 400  # of a table on the page; the CSV file has the rest


@dataclass(frozen=True)
class TableCell:
    """A cell of a table: its plain text and its typography."""

    text: str
    bold: bool = False
    italic: bool = False
    heads_row: bool = False
    mark: str = ""
    lost: bool = False
    shade: int | None = None
    tone: str = ""


@dataclass(frozen=True)
class Typography:
    """How the values of a table look: frames like the table's, without the columns that look as usual.

    Attributes:
        texts: what the cells show instead of the values in the usual digits.
        bold: which values are bold: booleans.
        italic: likewise for italics.
        marks: superscript letters after a value: texts.
        lost: which values count failed trials or include them, shown in red with a sign: booleans.
        shades: how dark the background of a value is, from 0 to 1: numbers, missing for none.
        tones: "good", "warn" or "bad" for a value on green, yellow or red, which its words say, too.
    """

    texts: pd.DataFrame | None = None
    bold: pd.DataFrame | None = None
    italic: pd.DataFrame | None = None
    marks: pd.DataFrame | None = None
    lost: pd.DataFrame | None = None
    shades: pd.DataFrame | None = None
    tones: pd.DataFrame | None = None


@dataclass(frozen=True)
class Table:
    """A table, written as CSV at full precision, on request as LaTeX, and into the page.

    Attributes:
        name: the name of its files; any text, made safe for a file name.
        caption: one sentence.
        frame: the values; the index is shown where it has a name.
        typography: how they look.
        decimals: decimals of every float, or by column; by default floats have four significant digits, aligned where
            the values of a column are of similar size.
        note: the explanation of the marks, below the table.
        data: the content of the CSV file where ``frame`` is abridged for reading; ``frame`` itself by default.
        totals: rows at the end that sum up the others; LaTeX has a rule above them.
        latex: whether it is written as LaTeX, too.
    """

    name: str
    caption: str
    frame: pd.DataFrame
    typography: Typography = Typography()
    decimals: int | Mapping[str, int] | None = None
    note: str = ""
    data: pd.DataFrame | None = None
    totals: int = 0
    latex: bool = False

    def arranged(self, change: Callable[[pd.DataFrame], pd.DataFrame]) -> Table:
        """Return the table with its frame, and the frames of its typography, changed alike."""
        frames = {name: change(frame) for name, frame in vars(self.typography).items() if frame is not None}
        return replace(self, frame=change(self.frame), typography=Typography(**frames))

    @property
    def has_index(self) -> bool:
        """Whether the index is part of the table."""
        return any(name is not None for name in self.frame.index.names)

    @property
    def header(self) -> list[tuple[str, bool]]:
        """The title of each column and whether it holds numbers, the index first."""
        index = [(str(name), False) for name in self.frame.index.names] if self.has_index else []
        return index + [(str(name), _is_number(values)) for name, values in self.frame.items()]

    @property
    def rows(self) -> list[list[TableCell]]:
        """The cells row by row, those of the index first."""
        keys = self.frame.index.to_frame().itertuples(index=False) if self.has_index else [()] * len(self.frame)
        columns = [
            [
                TableCell(
                    text or cell_text(value, decimals), bool(bold), bool(italic), mark=mark or "", lost=bool(lost),
                    shade=None if shade is None or pd.isna(shade) else min(int(shade * SHADES), SHADES - 1),
                    tone=tone or "",
                )
                for value, text, bold, italic, mark, lost, shade, tone in zip(values, *styles, strict=True)
            ]
            for name, values in self.frame.items()
            for styles in [[self._styles(like_frame, name) for like_frame in vars(self.typography).values()]]
            for decimals in [self._decimals(name, values)]
        ]  # fmt: skip
        heads = [[TableCell(cell_text(value), heads_row=True) for value in key] for key in keys]
        return [[*head, *(column[i] for column in columns)] for i, head in enumerate(heads)]

    def _decimals(self, column: Any, values: pd.Series[Any]) -> int | None:
        decimals = self.decimals.get(column) if isinstance(self.decimals, Mapping) else self.decimals
        return usual_decimals(values) if decimals is None and _is_number(values) else decimals

    def _styles(self, like_frame: pd.DataFrame | None, column: object) -> list[object]:
        return [None] * len(self.frame) if like_frame is None or column not in like_frame else list(like_frame[column])


def _is_number(values: pd.Series[Any]) -> bool:
    return is_numeric_dtype(values) and not is_bool_dtype(values)


@dataclass(frozen=True)
class Figure:
    """A figure, written as SVG and PDF with its data as CSV, and drawn into the page.

    Attributes:
        name: the name of its files; any text, made safe for a file name.
        caption: one sentence or two; also the text for screen readers.
        figure: a matplotlib figure, best from :func:`bench.plots.style.grid`.
        data: the tidy data of the figure, written as CSV.
        shown: the table that a reader opens below it where ``data`` is too long to read: a frame, or a table with
            files of its own; ``data`` by default.
        live: a specification of Vega-Lite, values of JSON, that is drawn below the figure where scripts run.
    """

    name: str
    caption: str
    figure: matplotlib.figure.Figure
    data: pd.DataFrame
    shown: pd.DataFrame | Table | None = None
    live: Mapping[str, object] | None = None

    @property
    def table(self) -> Table:
        """The data as a table, for readers who cannot see the figure or want its numbers."""
        if isinstance(self.shown, Table):
            return self.shown
        return Table(self.name, "", self.data if self.shown is None else self.shown)


Part = Table | Figure


class File(NamedTuple):
    """A file of the report's folder that is listed among the downloads.

    Attributes:
        path: relative to the folder, such as ``"tables/trials.csv"``.
        about: one sentence on its content.
        content: its text, or a frame that is written as CSV with every digit, without its index.
    """

    path: str
    about: str
    content: str | pd.DataFrame

    @property
    def stem(self) -> str:
        """The path without its ending."""
        return self.path.rpartition(".")[0]


class Line(NamedTuple):
    """A short answer or warning: a few words and a text.

    Attributes:
        label: the few words.
        text: a sentence.
        part: what the label links to: the title of the section that has the rest, or a place in the reference of the
            documentation, such as ``"warnings#ties"``.
    """

    label: str
    text: str
    part: str = ""


def warning(label: str, text: str) -> Line:
    """Return a line whose label is the title of an entry of the page of warnings, and links to it."""
    return Line(label, text, f"warnings#{slug(label)}")


@dataclass(frozen=True)
class Card:
    """A framed statement at the head of a section.

    Attributes:
        text: a sentence.
        tone: "claim" for a statement that the results support, "open" for one that leaves the question open, "limit"
            for a limit of the results.
    """

    text: str
    tone: Literal["claim", "open", "limit"]


@dataclass(frozen=True)
class Section:
    """A section of the page.

    Attributes:
        title: its heading.
        text: paragraphs of plain text.
        items: tables and figures.
        cards: framed statements above everything else.
        lines: short answers and warnings, each with a label; those of the first section of a page stand below its
            pictures.
        lost: a sentence on how many trials failed, shown in red with a sign.
        folded: whether a reader opens this subsection to see more than its title; it is printed only when it is open.
        sections: subsections, one level deep.
        files: what the report's folder has besides the files of tables and figures.
        lists_files: whether the list of all files of the report stands at its end.
    """

    title: str
    text: tuple[str, ...] = ()
    items: tuple[Part, ...] = ()
    cards: tuple[Card, ...] = ()
    lines: tuple[Line, ...] = ()
    sections: tuple[Section, ...] = ()
    lost: str = ""
    folded: bool = False
    files: tuple[File, ...] = ()
    lists_files: bool = False

    def __post_init__(self) -> None:
        """Raise TypeError for parts that the page cannot show, so that a plug-in's mistake is found at its source."""
        if not all(isinstance(card, Card) for card in _sequence(self.cards)):
            raise TypeError("a section's cards must be Card")
        if not all(isinstance(line, Line) for line in _sequence(self.lines)):
            raise TypeError("a section's lines must be Line")
        short = (*(card.text for card in self.cards), *(text for line in self.lines for text in line))
        if not all(isinstance(text, str) for text in (self.title, self.lost, *short, *_sequence(self.text))):
            raise TypeError("a section's title, paragraphs, cards and lines must be texts")
        if not all(isinstance(item, Table | Figure) for item in _sequence(self.items)):
            raise TypeError("a section's items must be Table or Figure")
        if any(not isinstance(section, Section) or section.sections for section in _sequence(self.sections)):
            raise TypeError("a section's sections must be Section, without sections of their own")
        if not all(isinstance(file, File) for file in _sequence(self.files)):
            raise TypeError("a section's files must be File")

    def joined(self, other: Section) -> Section:
        """Return this section with the parts of another one after its own."""
        several = ("text", "items", "cards", "lines", "sections", "files")
        parts: dict[str, Any] = {name: (*getattr(self, name), *getattr(other, name)) for name in several}
        lost = "\n".join(filter(None, (self.lost, other.lost)))
        return replace(self, lost=lost, lists_files=self.lists_files or other.lists_files, **parts)


def _sequence(several: object) -> Sequence[object]:
    """Return a tuple or list; raise for others: a text is a sequence of letters, a generator can be read only once."""
    if not isinstance(several, tuple | list):
        raise TypeError(f"a section's parts come in tuples, not in a {type(several).__name__}")
    return several
