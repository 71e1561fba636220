"""Take the source of a Python file, as a language model writes it, for an optimizer; it is run where it is unpacked."""

from __future__ import annotations

import inspect
import pickle
import sys
import traceback
from types import ModuleType
from typing import Any

from bench.errors import BenchError
from bench.helpers.text import short_hash
from bench.optimizer import Optimizer
from bench.plugins.functions import asks_and_tells, takes_budget
from bench.plugins.packing import PackedObject
from bench.sandbox.messages import describe_error

FILE = "<candidate>"
"""The file that tracebacks name."""

_MODULE = "candidate"


class _Source:
    """Is unpickled as the optimizer that the text defines."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __reduce__(self) -> Any:
        return plugin, (self.text,)


def packed(text: str) -> PackedObject:
    """Return the source as it travels to the processes of its trials; it is not run here."""
    return PackedObject(pickle.dumps((_Source(text), [], {})), short_hash(text.encode()))


def plugin(text: str) -> Any:
    """Run the source; return the last class or function in it that can be an optimizer.

    A function is one that takes ``objective`` first or ``rng`` second.

    Raises:
        BenchError: where there is none, or the source raises.
    """
    module = ModuleType(_MODULE)
    sys.modules[_MODULE] = module  # dataclasses look up annotations there
    try:
        exec(compile(text, FILE, "exec"), vars(module))
    except (Exception, SystemExit) as error:  # it may raise anything
        raise BenchError(f"the source cannot be loaded: {describe_error(error)}") from error
    found = [value for value in vars(module).values() if getattr(value, "__module__", "") == _MODULE and _fits(value)]
    if not found:
        raise BenchError(
            "the source defines no optimizer: it needs a class X(budget, dim) with __call__(self, func), a function "
            "(objective, rng), a class with ask and tell, or a bench.Optimizer"
        )
    return found[-1]


def located(error: BaseException) -> str:
    """Return an error as :func:`describe_error` does; one in a source begins with the line, as in "line 12: …"."""
    inner = error
    while isinstance(inner, BenchError) and inner.__cause__ is not None:
        inner = inner.__cause__
    lines = [frame.lineno for frame in traceback.extract_tb(inner.__traceback__) if frame.filename == FILE]
    if isinstance(inner, SyntaxError) and inner.filename == FILE:
        lines.append(inner.lineno)
    return f"line {lines[-1]}: {describe_error(inner)}" if lines else describe_error(error)


def _fits(value: Any) -> bool:
    if isinstance(value, type):
        return (
            (issubclass(value, Optimizer) and not inspect.isabstract(value))
            or asks_and_tells(value)
            or takes_budget(value)
        )
    if not inspect.isfunction(value):
        return False
    first = [*inspect.signature(value).parameters][:2]
    return len(first) == 2 and (first[0] == "objective" or first[1] == "rng")
