"""The directive ``drawing``: a figure of ``figures/NAME.py`` in a light and a dark version, with its code.

The file has a function ``draw(ink)`` that returns a matplotlib Figure; ``ink`` is the colour of lines and letters.
"""

from __future__ import annotations

import importlib
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

INKS = {"light": "#222832", "dark": "#ced6dd"}  # the theme's text on its two backgrounds
COLOURS = {  # of Okabe and Ito (2008), those that stand out on each
    "light": ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00"),
    "dark": ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442"),
}


class Drawing(SphinxDirective):
    """``{drawing} NAME`` with an option ``alt``; the content is the caption."""

    required_arguments = 1
    has_content = True
    option_spec = {"alt": directives.unchanged_required}  # noqa: RUF012  (docutils' own protocol)

    def run(self) -> list[nodes.Node]:
        """Return both images, the caption and the code, folded."""
        name, caption = self.arguments[0], "\n".join(self.content)
        source = Path(self.env.srcdir) / "figures" / f"{name}.py"
        if not source.exists():
            raise self.error(f"there is no figure {source}")
        self.env.note_dependency(str(source))
        images = "\n\n".join(
            f":::{{image}} /_generated/figures/{name}-{mode}.svg\n:alt: {self.options['alt']}\n:class: only-{mode}\n:::"
            for mode in INKS
        )
        folded = (
            f"::::{{dropdown}} The code of this figure\n```{{literalinclude}} /figures/{name}.py\n"
            ":language: python\n```\n::::"
        )
        return self.parse_text_to_nodes(f"{images}\n\n:::{{div}} drawing-caption\n{caption}\n:::\n\n{folded}")


def draw_all(app: Sphinx) -> None:
    """Draw every figure whose file is newer than its drawing."""
    import matplotlib as mpl

    mpl.use("agg")
    folder = Path(app.srcdir) / "_generated" / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    for source in sorted((Path(app.srcdir) / "figures").glob("[a-z]*.py")):
        for mode, ink in INKS.items():
            path = folder / f"{source.stem}-{mode}.svg"
            if path.exists() and path.stat().st_mtime > source.stat().st_mtime:
                continue
            with mpl.rc_context(_settings(mode)):
                figure = importlib.import_module(f"figures.{source.stem}").draw(ink)
                figure.savefig(path, transparent=True, metadata={"Date": None})


def _settings(mode: str) -> dict[str, object]:
    from cycler import cycler

    every = ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color", "axes.titlecolor")
    return {
        "font.size": 9, "figure.figsize": (6.4, 2.6), "figure.constrained_layout.use": True, "axes.spines.top": False,
        "axes.spines.right": False, "svg.hashsalt": "bench", "legend.frameon": False, "lines.linewidth": 1.5,
        "axes.prop_cycle": cycler(color=COLOURS[mode]), **dict.fromkeys(every, INKS[mode]),
    }  # fmt: skip


def setup(app: Sphinx) -> dict[str, bool]:
    """Draw the figures when the build begins, and know the directive."""
    app.add_directive("drawing", Drawing)
    app.connect("builder-inited", draw_all)
    return {"parallel_read_safe": True}
