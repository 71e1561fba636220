"""Read JSON and TOML that users give or that may be damaged; every fault of a text is a ValueError."""

from __future__ import annotations

import errno
import json
import re
import stat
import tomllib
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any

Json = Any
"""A value of JSON or TOML as a text has it: whoever reads it checks its type."""

JsonObject = dict[str, Json]

DEEPEST = 100
"""Levels of lists and tables; the parsers, and all that copies or prints a value, call themselves for each."""

_DOTTED = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++\s*+\.\s*+){{{DEEPEST}}}""")
"""It finds a dotted key of DEEPEST levels or more; the parser of TOML takes minutes for a very long one."""

_TOO_DEEP = f"it is nested more than {DEEPEST} levels deep"


def read_text(path: Path) -> str:
    """Return the text of a file, which must be a regular one: others, such as a pipe or /dev/zero, may never end.

    Raises:
        OSError: where there is no such file, or it cannot be read.
        ValueError: where it is not UTF-8 text.
    """
    if not stat.S_ISREG(path.stat().st_mode):
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None


def parse_json(text: str | bytes) -> Json:
    """Return the value of a JSON text; raises ValueError for any other text, and for one that is nested too deeply."""
    return _parsed(json.loads, text)


def parse_toml(text: str) -> JsonObject:
    """Return the tables of a TOML text; raises ValueError for any other text, and for one that is nested too deeply."""
    if _DOTTED.search(text):
        raise ValueError(_TOO_DEEP)
    tables: JsonObject = _parsed(tomllib.loads, text)
    return tables


def _parsed(parser: Callable[[Any], Json], text: str | bytes) -> Json:
    try:
        value = parser(text)
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    level = [value]
    for _ in range(DEEPEST):
        lists = [part.values() if isinstance(part, dict) else part for part in level if isinstance(part, dict | list)]
        level = list(chain.from_iterable(lists))
        if not level:
            return value
    raise ValueError(_TOO_DEEP)
