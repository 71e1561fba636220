"""A table as LaTeX (booktabs)."""

from __future__ import annotations

import pandas as pd

from bench.report.parts import Cell, Table

SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': r"\textquotedbl{}", "–": "--", "−": r"$-$", "∞": r"$\infty$", "±": r"$\pm$",
    "×": r"$\times$", "≤": r"$\leq$", "≥": r"$\geq$", "Δ": r"$\Delta$", "δ": r"$\delta$", "α": r"$\alpha$",
}  # fmt: skip


def escape(text: str) -> str:
    """Return plain text as LaTeX shows it, on one line."""
    return "".join(SPECIAL.get(character, character) for character in " ".join(text.split()))


def to_latex(table: Table, label: str) -> str:
    """Return a table environment with caption, label ``tab:<label>`` and note; needs the package booktabs."""
    rows = [[_set(cell) for cell in row] for row in table.rows]
    frame = pd.DataFrame(rows, columns=[escape(title) for title, _ in table.header])
    text: str = (
        frame.style.hide(axis="index")
        .to_latex(
            hrules=True,
            column_format="".join("r" if numeric else "l" for _, numeric in table.header),
            caption=escape(table.caption),
            label=f"tab:{label}",
            position="htbp",
            position_float="centering",
        )
    )  # fmt: skip
    note = f"\\par\\smallskip\\footnotesize {escape(table.note)}\n" if table.note else ""
    return text.replace("\\end{table}", note + "\\end{table}")


def _set(cell: Cell) -> str:
    text = escape(cell.text)
    text = f"\\textit{{{text}}}" if cell.italic else text
    return f"\\textbf{{{text}}}" if cell.bold else text
