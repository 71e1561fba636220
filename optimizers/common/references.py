"""The works that the optimizers come from, which ``optimizers/references.bib`` holds."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from bench.bibtex import Work, parse


def works(*keys: str) -> str:
    """Return the BibTeX of the works with these keys."""
    return "\n".join(_library()[key].bibtex for key in keys)


@cache
def _library() -> dict[str, Work]:
    text = (Path(__file__).parents[1] / "references.bib").read_text(encoding="utf-8")
    return {work.key: work for work in parse(text)}
