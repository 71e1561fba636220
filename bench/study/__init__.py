"""A study: what runs on what, how often, with what budget; one module for each kind of value that a study holds."""

from bench.study.entries import Entry
from bench.study.study import Fingerprints, Study

__all__ = ["Entry", "Fingerprints", "Study"]
