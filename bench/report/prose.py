"""Write the sentences of a topic from its template ``words.j2``: text where a writer finds it, facts from Python."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import isnan
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from bench.report.wording import count, listing, p_text, percent


def speaker(package: str, **facts: Any) -> Callable[..., str]:
    """Return a function that writes a sentence of a topic by its name: the macro of that name in its template.

    Facts are what the macros refer to by name; further arguments of the function are those of the macro. Line ends
    and indentation of the template become single spaces; a sentence that does not apply is "".
    """
    sentences: Any = _environment(package).get_template("words.j2").make_module(facts)
    return lambda name, *arguments: " ".join(getattr(sentences, name)(*arguments).split())


@cache
def _environment(package: str) -> Environment:
    environment = Environment(
        loader=PackageLoader(package, ""), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.globals |= {"count": count, "listing": listing, "p_text": p_text, "percent": percent, "isnan": isnan}
    return environment
