"""The works that a report cites, by key."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.resources import files

from bench.bibtex import Work, parse


@cache
def library() -> dict[str, Work]:
    """Return the works whose methods a report uses, by key."""
    text = (files("bench.report") / "references.bib").read_text(encoding="utf-8")
    return {reference.key: reference for reference in parse(text)}


def united(references: list[Work], others: list[Work]) -> tuple[list[Work], list[Work]]:
    """Return ``references`` with those of ``others`` that they lack, and ``others`` as they are named there.

    BibTeX does not tell keys by their case, so another work under a key that is taken gets a number to its key.
    """
    taken = {reference.key.lower(): reference for reference in references}
    named = []
    for other in others:
        number, each = 1, other
        while not taken.get(each.key.lower(), each).is_same(each):
            number += 1
            each = replace(other, key=f"{other.key}-{number}")
        taken[each.key.lower()] = each
        named.append(each)
    return list(taken.values()), named
