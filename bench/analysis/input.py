"""Say in one sentence what a function of this package misses: an argument of another kind, or a column of a frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from inspect import signature
from types import TracebackType
from typing import Any

import numpy as np
import pandas as pd

from bench.helpers.errors import BenchError

KINDS: dict[str, tuple[type, str]] = {
    "pd.DataFrame": (pd.DataFrame, "a frame, such as results.frame"),
    "Floats": (np.ndarray, "an array of numbers, such as pairs['p'].to_numpy()"),
    "Traces": (Mapping, "traces, such as results.traces"),
}
"""By annotation: what an argument must be, and what to give."""


def guarded(function: Callable[..., object]) -> Callable[..., object]:
    """Wrap a function so that it raises BenchError for frames and traces of another kind or without a column.

    Functions without such arguments stay as they are. Whatever else raises within one does so as before.
    """
    parameters = signature(function).parameters
    kinds = {name: KINDS[each.annotation] for name, each in parameters.items() if each.annotation in KINDS}
    if not kinds:
        return function

    @wraps(function)
    def with_sentences(*args: Any, **kwargs: Any) -> object:
        given = dict(zip(parameters, args, strict=False)) | kwargs
        for name, (kind, example) in kinds.items():
            if name in given and not isinstance(given[name], kind):
                raise BenchError(
                    f"{function.__name__} takes as {name!r} {example}, not an object of {type(given[name]).__name__}"
                )
        try:
            return function(*args, **kwargs)
        except KeyError as error:
            frames = {name: given[name] for name in kinds if isinstance(given.get(name), pd.DataFrame)}
            lacking = [name for name, frame in frames.items() if error.args and error.args[0] not in [*frame]]
            if not lacking or not _of_pandas(error.__traceback__):
                raise
            missing = str(error.args[0])
            what = missing if missing.startswith(('"', "'", "[", "None of")) else f"column {missing!r}"
            names = ", ".join(map(str, frames[lacking[0]]))
            raise BenchError(
                f"{function.__name__} misses in {lacking[0]!r}: {what}; it has the columns {names}"
            ) from error

    return with_sentences


def _of_pandas(traceback: TracebackType | None) -> bool:
    """Return whether pandas itself raised, which looks for columns, and no mapping of ours."""
    while traceback and traceback.tb_next:
        traceback = traceback.tb_next
    return traceback is not None and str(traceback.tb_frame.f_globals.get("__name__")).startswith("pandas")
