"""The interactive part of the page: what one may look further into, drawn by Vega from data inside the page.

explore (findings -> a dict for JSON) -> part (that dict, the library and the script, ready for the template).
"""

from bench.report.interactive.part import Interactive, interactive

__all__ = ["Interactive", "interactive"]
