"""Tables, figures and one self-contained page of a study's folder.

A plug-in adds sections by the entry-point group ``bench.report_sections``: a callable that takes
:class:`bench.Results` and returns a list of :class:`Section`, empty when the study is not its own.
"""

from bench.report.parts import Card, Figure, Part, Section, Table
from bench.report.write import write_report

__all__ = ["Card", "Figure", "Part", "Section", "Table", "write_report"]
