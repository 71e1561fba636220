"""The directive ``performance``: what ``nox -s performance`` measured, from reference/performance.json."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from extensions.pages import code, plain, table


class Performance(SphinxDirective):
    """``{performance}``: a sentence on the run, and a row for each thing measured."""

    def run(self) -> list[nodes.Node]:
        """Return both."""
        source = Path(self.env.srcdir) / "reference" / "performance.json"
        self.env.note_dependency(str(source))
        return self.parse_text_to_nodes(text(json.loads(source.read_text(encoding="utf-8"))))


def text(measured: dict[str, Any]) -> str:
    """Return the Markdown of what was measured."""
    packages = ", ".join(f"{name} {version}" for name, version in measured["packages"].items())
    commit = str((measured["git"] or {}).get("commit") or "unknown")[:10]
    warning = "**A trial run with small sizes: these numbers mean nothing.** " if measured["quick"] else ""
    about = (
        f"{warning}Measured on {measured['date']} on {measured['cores']} cores of {measured['processor']}, "
        f"{measured['memory_gb']:.0f} GB, {measured['system']}, with Python {measured['python']}, {packages}; "
        f"commit {commit}."
    )
    rows = [(plain(row["measured"]), plain(row["value"]), code(row["command"])) for row in measured["rows"]]
    return f"{about}\n\n{table(('measured', 'value', 'alone'), rows)}\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("performance", Performance)
    return {"parallel_read_safe": True}
