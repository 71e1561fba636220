"""The topics of a report: a folder each, in which its section, words, figures and findings lie together.

A topic is registered by an entry point of ``bench.report_sections``, those of the harness as a stranger's: a
:class:`Topic`, or a function that takes the :class:`Findings` of a study and returns a :class:`bench.report.Section`,
a list of them, or None for a study of another kind.
"""

from bench.results.results import StoredResults
from bench.study.descriptions import repairing
from bench.topics.findings import Findings
from bench.topics.time.figures import timing_figure
from bench.topics.topic import Topic
from bench.topics.write import write_report

__all__ = ["Findings", "StoredResults", "Topic", "repairing", "timing_figure", "write_report"]
