"""The directive ``performance``: what ``nox -s performance`` measured, from reference/performance.json."""

from __future__ import annotations

import json
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from extensions.pages import performance


class Performance(SphinxDirective):
    """``{performance}``: a sentence on the run, and a row for each thing measured."""

    def run(self) -> list[nodes.Node]:
        """Return both."""
        source = Path(self.env.srcdir) / "reference" / "performance.json"
        self.env.note_dependency(str(source))
        return self.parse_text_to_nodes(performance(json.loads(source.read_text(encoding="utf-8"))))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("performance", Performance)
    return {"parallel_read_safe": True}
