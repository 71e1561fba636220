"""An atlas: the implementations of each method that several libraries have, compared with each other.

Read which implementations a method has (:mod:`bench.atlas.table`), run them on the same functions
(:mod:`bench.atlas.runs`), test which of them differ (:mod:`bench.atlas.compare`), and write the pages
(:mod:`bench.atlas.write`).
"""

from bench.atlas.compare import Atlas, compare
from bench.atlas.runs import survey
from bench.atlas.table import Implementation, Method, methods
from bench.atlas.write import write_atlas

__all__ = ["Atlas", "Implementation", "Method", "compare", "methods", "survey", "write_atlas"]
