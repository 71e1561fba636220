"""The interactive part of the page: what one may look further into, drawn by Vega from data inside the page.

The data are values of JSON, which ``bench.topics.explore`` makes of a study; ``part`` joins them with the
library and the script, ready for the template.
"""

from bench.report.interactive.part import Interactive, interactive

__all__ = ["Interactive", "interactive"]
