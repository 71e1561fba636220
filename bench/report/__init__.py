"""Write the report of a study: tables, figures and one self-contained page.

A plug-in adds sections by the entry-point group ``bench.report_sections``: a callable that takes
:class:`bench.Results` and returns a list of :class:`Section`, empty for a study of another family.
"""

from bench.report.conditions import repairing
from bench.report.parts import Card, Figure, Part, Section, Table
from bench.report.plots import timing_figure
from bench.report.standalone import write_page
from bench.report.wording import count, leaders, listing, seconds
from bench.report.write import write_report

__all__ = [
    "Card",
    "Figure",
    "Part",
    "Section",
    "Table",
    "count",
    "leaders",
    "listing",
    "repairing",
    "seconds",
    "timing_figure",
    "write_page",
    "write_report",
]
