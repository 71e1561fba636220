"""Write tables and figures to files, the same bytes for the same results."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import matplotlib.figure
import pandas as pd
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG

from bench.report.latex import to_latex
from bench.report.parts import Figure, Table

TABLES, FIGURES = "tables", "figures"


def save_table(table: Table, folder: Path, name: str) -> list[str]:
    """Write a table as CSV (full precision) and LaTeX; return the paths relative to ``folder``."""
    (folder / TABLES).mkdir(exist_ok=True)
    paths = [f"{TABLES}/{name}.csv", f"{TABLES}/{name}.tex"]
    if table.data is None:
        save_csv(table.frame, folder / paths[0], index=table.has_index)
    else:
        save_csv(table.data, folder / paths[0], index=False)
    (folder / paths[1]).write_text(to_latex(table, name), encoding="utf-8", newline="\n")
    return paths


def save_figure(figure: Figure, folder: Path, name: str) -> tuple[str, list[str]]:
    """Write a figure as SVG and PDF and its data as CSV; return the SVG's text and the paths relative to ``folder``."""
    (folder / FIGURES).mkdir(exist_ok=True)
    paths = [f"{FIGURES}/{name}.{kind}" for kind in ("svg", "pdf", "csv")]
    svg, pdf = _draw(figure.figure)
    (folder / paths[0]).write_bytes(svg)
    (folder / paths[1]).write_bytes(pdf)
    save_csv(figure.data, folder / paths[2], index=False)
    return svg.decode(), paths


def _draw(figure: matplotlib.figure.Figure) -> tuple[bytes, bytes]:
    """Return a figure as SVG and as PDF without dates; its layout is computed once."""
    svg, pdf = io.BytesIO(), io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the font may lack letters of a label
        canvas = FigureCanvasSVG(figure)
        if (engine := figure.get_layout_engine()) is not None:
            engine.execute(figure)
            figure.set_layout_engine("none")
        canvas.print_svg(svg, metadata={"Date": None})  # type: ignore[no-untyped-call]
        FigureCanvasPdf(figure).print_pdf(pdf, metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    return svg.getvalue(), pdf.getvalue()


def save_csv(frame: pd.DataFrame, path: Path, *, index: bool) -> None:
    """Write a frame as CSV with every digit, the same bytes on every system."""
    frame.to_csv(path, index=index, lineterminator="\n", encoding="utf-8")
