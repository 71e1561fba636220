"""Make the interactive part ready for the page: data that cannot end their element, scripts with their hashes."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from dataclasses import dataclass
from importlib import resources

from markupsafe import Markup

from bench.report.interactive.library import library

TITLE = "Look further"
ANCHOR = "look-further"  # of the part; a state of the part follows it in a link, after "?"
IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w-]+)\.js";\n', re.MULTILINE)  # as the formatter writes it


@dataclass(frozen=True)
class Interactive:
    """The interactive part of a page.

    Attributes:
        title: its heading.
        anchor: its id.
        hint: a sentence in its place where there is none, else "".
        data: JSON; this and the next two are trusted, as :class:`Markup`, where there are any.
        scripts: JavaScript, to be run in this order.
        style: CSS.
    """

    title: str = TITLE
    anchor: str = ANCHOR
    hint: str = ""
    data: str = ""
    scripts: tuple[str, ...] = ()
    style: str = ""

    @property
    def hashes(self) -> list[str]:
        """The hashes of the scripts, by which the page's policy knows them."""
        return [digest(script) for script in self.scripts]


def interactive(data: object) -> Interactive:
    """Return the interactive part that shows data, which are values of JSON (see ``script/main.js``)."""
    scripts = (_script(library()), _script(explorer()))
    return Interactive(data=as_json(data), scripts=scripts, style=Markup(_asset("explore.css")))


def explorer() -> str:
    """Return the script that draws."""
    return f'(() => {{\n"use strict";\n{in_one_scope("main")}}})();'


def in_one_scope(name: str) -> str:
    """Return a module and its imports as one script, each module after those that it needs.

    A page that is one file cannot import, so the modules share a scope: no two may declare the same name.
    """
    texts: dict[str, str] = {}

    def add(name: str) -> None:
        text = _asset(f"script/{name}.js")
        for needed in IMPORT.findall(text):
            if needed not in texts:
                add(needed)
        texts[name] = re.sub("^export ", "", IMPORT.sub("", text), flags=re.MULTILINE)

    add(name)
    return "\n".join(texts.values())


def as_json(data: object) -> Markup:
    """Return JSON for an element of HTML: in ASCII, and without a character that could end the element."""
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


def digest(script: str) -> str:
    """Return the SHA-256 of a script as a Content-Security-Policy has it."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _script(text: str) -> Markup:
    """Return JavaScript that cannot end its element: in a text, a template or an expression the two mean the same."""
    return Markup(text.replace("</script", "<\\/script").replace("<!--", "<\\!--"))


def _asset(name: str) -> str:
    return resources.files("bench.report.interactive").joinpath(name).read_text(encoding="utf-8")
