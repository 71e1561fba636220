"""Check what a trial process answers: an optimizer may have written it, so nothing in it is believed unseen."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from typing import Any

import numpy as np

from bench.contract.objective import IMPROVEMENT, LOGGED, Logs, Trace
from bench.contract.typing import Flags, Floats
from bench.helpers.parsing import JsonObject
from bench.helpers.text import printable
from bench.trial.columns import MEASURED, Column, Row
from bench.trial.trial import finished

_NOUNS = {int: "whole number", float: "number", str: "text"}


class RefusedError(RuntimeError):
    """An answer is refused, with the reason."""


@dataclass(frozen=True)
class Box:
    """The box of a problem, in which an answer must lie: variables, (d,) bounds and integer flags, known points."""

    variables: tuple[str, ...]
    lower: Floats
    upper: Floats
    integer: Flags
    initial: Floats | None = None

    @classmethod
    def of(cls, described: Any) -> Box:
        """Return the box that :func:`bench.execution.trial_process.load_problem` describes.

        Raises:
            RefusedError: for what describes none.
        """
        try:
            lower, upper = (np.array(described[key], dtype=np.float64) for key in ("lower", "upper"))
            variables, integer = tuple(described["variables"]), np.array(described["integer"], dtype=bool)
            known = described.get("initial")
            initial = None if known is None else np.array(known, dtype=np.float64).reshape(-1, len(lower))
        except (TypeError, ValueError, KeyError, AttributeError) as error:
            raise RefusedError("its problem's bounds cannot be read") from error
        named = all(isinstance(name, str) for name in variables)
        if not named or lower.ndim != 1 or not lower.shape == upper.shape == integer.shape:
            raise RefusedError("its problem's bounds cannot be read")
        return cls(variables, lower, upper, integer, initial)

    def holds(self, x: Floats) -> bool:
        """Return whether the (d,) point lies in the box."""
        return bool(((x >= self.lower) & (x <= self.upper)).all())


def error(answer: object) -> str:
    """Return why a trial failed by its own account, "" where it claims a result; raises RefusedError for neither."""
    if not isinstance(answer, dict):
        raise RefusedError("it is no table of fields")
    reason = answer.get("error", "")
    if not isinstance(reason, str):
        raise RefusedError("its error is no text")
    return printable(reason, 4000)


def row(answer: JsonObject, box: Box, budget: int) -> Row:
    """Return the row of the finished trial that an answer claims, where it can be one.

    Args:
        answer: the fields of :func:`bench.execution.trial_process.as_answer`, and the metrics.
        box: of the trial's problem.
        budget: evaluations that the trial may have made.

    Raises:
        RefusedError: for missing fields, other types, and values that contradict each other or the study.
        ValueError: for variables or metrics that cannot be columns.
    """
    measured = {column.name: _value(answer, column) for column in MEASURED}
    for column in MEASURED:
        if column.kind is not str:
            _check(column, measured | {"budget": budget})
    fun, nfev, stop = measured["fun"], measured["nfev"], measured["stop"]
    x, trace = np.frombuffer(_bytes(answer, "x"), "<f8"), Trace.unpacked(_bytes(answer, "trace"))
    _check_trace(trace, fun, nfev)
    if x.shape != box.lower.shape:
        raise RefusedError(f"its best point has {len(x)} values, in {len(box.lower)} dimensions")
    if fun < inf and not box.holds(x):
        raise RefusedError("its best point lies outside the box")
    if not np.isfinite(x).all():  # nothing was evaluated there
        raise RefusedError("its best point has values that are no numbers")
    if (np.rint(x) != x)[box.integer].any():
        raise RefusedError("its best point has an integer variable that is no whole number")
    if (nfev == budget) != (stop == "budget"):  # a word that only the harness uses, and only at the end of the budget
        raise RefusedError(f"it stopped by {printable(stop, 50)!r} after {nfev} of {budget} evaluations")
    measured["stop"] = printable(stop, 201)
    metrics = answer.get("metrics")
    if not isinstance(metrics, dict) or not all(type(value) is float for value in metrics.values()):
        raise RefusedError("the metrics of its best point are no numbers")
    return finished(measured, box.variables, x, metrics, trace, _log(answer, nfev))


def _value(answer: JsonObject, column: Column) -> Any:
    value = answer.get(column.name)
    if type(value) is not column.kind or value != value:  # NaN
        raise RefusedError(f"its {column.name} is no {_NOUNS[column.kind]}")
    return value


def _check(column: Column, values: Row) -> None:
    """Refuse a number that is not within the bounds of its column; times are finite."""
    value, (least, most, within) = values[column.name], column.limits
    most = values.get(within, most)
    if not least <= value <= most or (column.unit and value == inf):
        raise RefusedError(f"its {column.name} is {value!s:.30}, and must be from {least} to {most}")


def _log(answer: JsonObject, nfev: int) -> Logs:
    """Return the log of an optimizer; refuse one that :class:`bench.contract.objective.Log` would not keep."""
    log = answer.get("log")
    if not isinstance(log, dict) or len(log) > LOGGED // 10:
        raise RefusedError("its log cannot be read")
    kept: Logs = {}
    for name, pairs in log.items():
        if not isinstance(pairs, list) or len(pairs) > LOGGED or not all(_is_logged(pair, nfev) for pair in pairs):
            raise RefusedError("its log cannot be read")
        kept[printable(name, 100)] = [(evaluations, value) for evaluations, value in pairs]
        if any(one[0] >= other[0] for one, other in pairwise(pairs)):
            raise RefusedError("the evaluations of its log do not increase")
    return kept


def _is_logged(pair: object, nfev: int) -> bool:
    return (
        isinstance(pair, list) and len(pair) == 2 and type(pair[0]) is int and 0 <= pair[0] <= nfev
        and (pair[1] is None or (type(pair[1]) is float and isfinite(pair[1])))
    )  # fmt: skip


def _check_trace(trace: Trace, fun: float, nfev: int) -> None:
    """Refuse a trace that is none of the run."""
    made, values = trace.evaluations, trace.values
    if not len(made):
        if fun == inf:
            return  # no point inside the box
        raise RefusedError("its trace is empty")
    if made[0] < 1 or made[-1] > nfev or (made[1:] <= made[:-1]).any():  # differences may overflow
        raise RefusedError("the evaluations of its trace do not increase from 1 to their number")
    if not np.isfinite(values).all() or (values[1:] >= values[:-1]).any():
        raise RefusedError("the values of its trace do not decrease")
    if values[-1] != fun:
        raise RefusedError(f"its trace ends at {float(values[-1])!r}, its best value is {fun!r}")


def _bytes(answer: JsonObject, name: str) -> bytes:
    """Return the bytes of numbers of 8 bytes, or of a trace's improvements of 16, from their text in base 64."""
    text = answer.get(name)
    try:
        data = base64.b64decode(text, validate=True)  # type: ignore[arg-type]
    except (TypeError, ValueError, binascii.Error) as error:
        raise RefusedError(f"its {name} cannot be read") from error
    if len(data) % (IMPROVEMENT if name == "trace" else 8):
        raise RefusedError(f"its {name} cannot be read")
    return data
