"""A study: its problems, optimizers, trials and budget; one module for each kind of value."""

from bench.study.entries import Entry
from bench.study.study import Study

__all__ = ["Entry", "Study"]
