"""The machinery of a page: sections of text, tables and figures become one HTML file, LaTeX, CSV, SVG and PDF.

It knows no statistic and no study; :mod:`bench.topics` makes the sections of a study's report.
"""

from bench.report.parts import Card, Figure, File, Line, Part, Section, Table, Typography
from bench.report.standalone import write_page
from bench.report.wording import count, leaders, listing, seconds

__all__ = [
    "Card", "Figure", "File", "Line", "Part", "Section", "Table", "Typography", "count", "leaders", "listing",
    "seconds", "write_page",
]  # fmt: skip
