"""The directive ``columns``: the columns of a trial, from the table that the code has."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from bench.columns import COLUMNS, FEATURES, PRECISION, Column
from extensions.pages import code, table, with_code

FRAME = {str: "text", int: "int64", float: "float64", bytes: "float64"}


class Columns(SphinxDirective):
    """``{columns}``: a row for each column of stores and frames."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        place = next(at for at, column in enumerate(COLUMNS, start=1) if column.name == "fun")
        every = (*COLUMNS[:place], PRECISION, *COLUMNS[place:], *FEATURES)
        rows = [(_names(each), _kind(each), each.unit, code("trials") * each.stored, _bounds(each)) for each in every]
        head = "column of the frame", "type", "unit", "view of the store", "meaning"
        return self.parse_text_to_nodes(table(head, rows))


def _names(column: Column) -> str:
    if column.names:
        return f"{code(f'{column.prefix}NAME')}, of {code(column.name)}"
    return code(column.name) if column.frame else f"none, of {code(column.name)}"


def _kind(column: Column) -> str:
    return FRAME[column.kind] if column.frame else "int64" if column.kind is int else "bytes"


def _bounds(column: Column) -> str:
    within = f"; at most {column.within}" * bool(column.within)
    return with_code(f"{column.meaning}{within}")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("columns", Columns)
    return {"parallel_read_safe": True}
