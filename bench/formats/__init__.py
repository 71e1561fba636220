"""Read and write the formats of other tools: a folder a format, with its reader and its writer side by side.

``importing`` makes a study's folder of what a reader finds, and ``exporting`` writes results by a writer. The format of
this project's own archives (``archive``) holds a whole folder, and has two commands of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from pkgutil import resolve_name
from typing import TYPE_CHECKING, NamedTuple, cast

if TYPE_CHECKING:
    from bench.formats.runs import FormatReader
    from bench.formats.trials import FormatWriter


class Format(NamedTuple):
    """A format, and the objects that read and write it, which are imported at their first use.

    Attributes:
        about: what holds results in this format or reads it, in a few words.
        reading: the reader's place in this package, "" where results cannot be imported.
        writing: the writer's place in this package, "" where results cannot be exported.
    """

    about: str
    reading: str = ""
    writing: str = ""

    @property
    def reader(self) -> FormatReader:
        """The reader of the format."""
        return cast("FormatReader", resolve_name(f"{__name__}.{self.reading}"))

    @property
    def writer(self) -> FormatWriter:
        """The writer of the format."""
        return cast("FormatWriter", resolve_name(f"{__name__}.{self.writing}"))


FORMATS = {
    "coco": Format("logs of COCO, for cocopp", "coco.reader:READER", "coco.writer:WRITER"),
    "ioh": Format("logs of IOHprofiler, for IOHanalyzer", "ioh.reader:READER", "ioh.writer:WRITER"),
    "table": Format("results of any tool in CSV, TSV, xlsx, parquet or JSON", "tables.foreign:READER"),
    "csv": Format("plain tables", "tables.reader:READER", "tables.writer:CSV"),
    "parquet": Format("the same with column types, by the extra 'parquet'", writing="tables.writer:PARQUET"),
}
"""All formats that are imported or exported, by the names that commands, help and reference have."""

IMPORTABLE = [name for name, each in FORMATS.items() if each.reading]
EXPORTABLE = [name for name, each in FORMATS.items() if each.writing]


def described(kinds: Iterable[str]) -> str:
    """Return the names of formats, with a few words on each."""
    return "; ".join(f"{kind}: {FORMATS[kind].about}" for kind in kinds)
