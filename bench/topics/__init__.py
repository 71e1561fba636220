"""The sections of a report: a folder each, in which its section, words, figures and findings lie together.

:mod:`bench.topics.page` lists them in their order. A stranger's section is an entry point of ``bench.report_sections``:
a function that takes the :class:`Findings` of a study and returns a :class:`bench.report.Section`, a list of them, or
None for a study of another kind. One with the title of a section of the page adds its parts to that section.
"""

from bench.results.results import StoredResults
from bench.study.descriptions import repairing
from bench.topics.findings import Findings
from bench.topics.write import write_report

__all__ = ["Findings", "StoredResults", "repairing", "write_report"]
