"""The directive ``columns``: the columns of a trial, from the table that the code has."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from bench.trial.columns import COLUMNS, FEATURES, PRECISION, Column
from extensions.pages import code, table, with_code

KINDS = {str: "text", int: "int64", float: "float64", bytes: "float64"}


class Columns(SphinxDirective):
    """``{columns}``: a row for each column of frames and stores."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        place = next(at for at, column in enumerate(COLUMNS, start=1) if column.name == "fun")
        rows = map(_row, (*COLUMNS[:place], PRECISION, *COLUMNS[place:], *FEATURES))
        return self.parse_text_to_nodes(table(("in the frame", "in the store", "type", "unit", "meaning"), rows))


def _row(column: Column) -> tuple[str, ...]:
    shown = code(f"{column.prefix}NAME" if column.names else column.name) if column.frame else "–"
    kind = KINDS[column.kind] if column.frame or column.kind is not bytes else "bytes"
    most = f", at most `{column.limits.within}`" * bool(column.limits.within)
    return shown, code(column.name) if column.stored else "–", kind, column.unit, with_code(f"{column.meaning}{most}")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("columns", Columns)
    return {"parallel_read_safe": True}
