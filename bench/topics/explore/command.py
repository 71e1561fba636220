"""The words of a command that makes one run of a study again."""

from __future__ import annotations

import json
import re
import shlex
from typing import Any

from bench.study import Entry, Study

WORD = re.compile(r"[A-Za-z][\w./:-]*")  # a text that TOML does not read as something else
TOML_WORDS = {"true", "false", "inf", "nan"}


def optimizer_words(entry: Entry) -> str:
    """Return an optimizer's words for ``bench solve PROBLEM``, quoted for a shell; "" where no command can make it."""
    if entry.name.startswith("imported:"):
        return ""
    return _words(entry, "--set")


def problem_words(entry: Entry, study: Study) -> str:
    """Return a problem's words likewise, with the study's handling of constraints where it is not the usual one."""
    words = _words(entry, "--problem-option")
    usual = study.constraints == type(study).constraints
    return f"{words} --constraints {study.constraints}" if words and not usual else words


def _words(entry: Entry, option: str) -> str:
    pairs = [(name, _value(value)) for name, value in entry.options.items()]
    if any(value is None for _, value in pairs):
        return ""
    return shlex.join([entry.name, *(word for name, value in pairs for word in (option, f"{name}={value}"))])


def _value(value: Any) -> str | None:
    """Return an option's value as TOML, or as the plain text that the command line reads as one."""
    if isinstance(value, str) and WORD.fullmatch(value) and value not in TOML_WORDS:
        return value
    if isinstance(value, bool | int | float | str | list):
        return json.dumps(value, ensure_ascii=False)
    return None
