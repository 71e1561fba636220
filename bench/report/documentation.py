"""Read the documentation's pages of warnings and words, which stand beside a report, and link its words to them."""

from __future__ import annotations

import re
from itertools import pairwise

from markdown_it import MarkdownIt
from markupsafe import Markup, escape

from bench.helpers.shipped import shipped
from bench.helpers.text import slug

GUIDES = {"warnings": "Every warning, and what to do.", "glossary": "The words of the page."}
"""The pages that stand beside a report, by the names of their sources, and what they are."""

TERMS = {
    "chance to end lower": "chance-to-end-lower", "≈": "approx", "A12": "a12", "ERT": "ert", "AOCC": "aocc",
    "targets": "target", "precision": "precision", "budget": "budget", "subject": "subject", "seed": "seed",
}  # fmt: skip
"""The words that the page links where they stand first, and their places in the glossary."""

WORD = re.compile("|".join(rf"(?<!\w){re.escape(term)}(?!\w)" for term in TERMS))
ANCHOR = re.compile(r"^\(([\w-]+)\)=$", re.MULTILINE)
LINK = re.compile(r"\[([^\]]+)\]\(([^)#]*)(#[^)]*)?\)")


def guide(name: str) -> tuple[str, Markup]:
    """Return title and HTML of a page of ``GUIDES``: each title in it has an id, and links to other pages are text."""
    source = (shipped("guides", "docs/reference") / f"{name}.md").read_text(encoding="utf-8")
    text = LINK.sub(_link, ANCHOR.sub(r'<a id="\1"></a>\n', source))
    parser = MarkdownIt("commonmark").enable("table")
    tokens = parser.parse(text)
    for token, inline in pairwise(tokens):
        if token.type == "heading_open":
            token.attrSet("id", slug(inline.content))
    title = source.partition("\n")[0].lstrip("# ")
    return title, Markup(parser.renderer.render(tokens, parser.options, {}))


def _link(found: re.Match[str]) -> str:
    label, page, place = found[1], found[2].removesuffix(".md"), found[3] or ""
    if page and page not in GUIDES:
        return label
    return f"[{label}]({page and f'{page}.html'}{place})"


class Documentation:
    """The links of one page to the guides beside it.

    Attributes:
        beside: whether they are beside it; else nothing is linked.
    """

    def __init__(self, beside: bool) -> None:
        self.beside = beside
        self._linked = set[str]()

    def address(self, place: str) -> str:
        """Return the address of a place such as ``"warnings#ties"``; "" where there is no guide or no place."""
        page, _, anchor = place.partition("#")
        return f"{page}.html#{anchor}" if self.beside and anchor else ""

    def terms(self, text: str) -> Markup:
        """Return a text whose terms link to the glossary where the page has them first."""
        return Markup(WORD.sub(self._term, str(escape(text))))

    def _term(self, found: re.Match[str]) -> str:
        term = found[0]
        if term in self._linked or not self.beside:
            return term
        self._linked.add(term)
        return f'<a href="{escape(self.address(f"glossary#{TERMS[term]}"))}">{term}</a>'
