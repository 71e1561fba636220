"""Link the words of a page to the documentation, where the metadata of this package name its address."""

from __future__ import annotations

import re
from importlib.metadata import metadata

from markupsafe import Markup, escape

TERMS = {
    "chance to end lower": "chance-to-end-lower", "≈": "approx", "A12": "a12", "ERT": "ert", "AOCC": "aocc",
    "targets": "target", "precision": "precision", "budget": "budget", "subject": "subject", "seed": "seed",
}  # fmt: skip
"""The words that the page links where they stand first, and their places in the glossary."""

WORD = re.compile("|".join(rf"(?<!\w){re.escape(term)}(?!\w)" for term in TERMS))


def site() -> str:
    """Return the address of the documentation that the package declares, "" without one."""
    declared = (each.partition(", ") for each in metadata("backlash-bench").get_all("Project-URL") or [])
    return next((url.rstrip("/") for name, _, url in declared if name == "Documentation"), "")


class Documentation:
    """The links of one page to the reference of the documentation.

    Attributes:
        site: its address; "" for none, and then nothing is linked.
    """

    def __init__(self, site: str) -> None:
        self.site = site
        self._linked = set[str]()

    def address(self, place: str) -> str:
        """Return the address of a place such as ``"warnings#ties"``; "" where there is no site or no place."""
        page, _, anchor = place.partition("#")
        return f"{self.site}/reference/{page}.html#{anchor}" if self.site and anchor else ""

    def terms(self, text: str) -> Markup:
        """Return a text whose terms link to the glossary where the page has them first."""
        return Markup(WORD.sub(self._term, str(escape(text))))

    def _term(self, found: re.Match[str]) -> str:
        term = found[0]
        if term in self._linked or not self.site:
            return term
        self._linked.add(term)
        return f'<a href="{escape(self.address(f"glossary#{TERMS[term]}"))}">{term}</a>'
