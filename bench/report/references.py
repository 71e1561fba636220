"""The works that a report cites, by key."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.resources import files

from bench.bibtex import Work, parse


@cache
def library() -> dict[str, Work]:
    """Return the works whose methods the reports use, by key."""
    text = (files("bench.report") / "references.bib").read_text(encoding="utf-8")
    return {work.key: work for work in parse(text)}


def merge_works(works: list[Work], others: list[Work]) -> tuple[list[Work], list[Work]]:
    """Return ``works`` with those of ``others`` that they lack, and ``others`` under their keys in that list.

    BibTeX ignores the case of keys, so a number is appended to the key of another work whose key is taken.
    """
    taken = {work.key.lower(): work for work in works}
    named = []
    for other in others:
        number, each = 1, other
        while not taken.get(each.key.lower(), each).is_same(each):
            number += 1
            each = replace(other, key=f"{other.key}-{number}")
        taken[each.key.lower()] = each
        named.append(each)
    return list(taken.values()), named
