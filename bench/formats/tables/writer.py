"""Plain tables of trials and of improvements, as CSV or Parquet, for R, Julia, spreadsheets and databases."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain

import numpy as np
import pandas as pd

from bench.analysis.cells import NO_TRACE
from bench.formats.trials import FormatWriter, readme
from bench.helpers.errors import require
from bench.results.results import StoredResults
from bench.trial.columns import FRAME

TEXTS, COUNTS = (tuple(column.name for column in FRAME if column.kind is kind) for kind in (str, int))
WRITERS: dict[str, Callable[[pd.DataFrame], str | bytes]] = {
    "csv": lambda frame: frame.to_csv(index=False, lineterminator="\n"),
    "parquet": lambda frame: frame.to_parquet(engine="pyarrow", index=False),
}


def files(results: StoredResults, kind: str) -> Iterator[tuple[str, str | bytes]]:
    """Return the path and the content of every file of the ``kind`` csv or parquet; a number keeps all its digits.

    Raises:
        BenchError: for parquet when pyarrow is not installed.
    """
    if kind == "parquet":
        require("pyarrow", "parquet", "the parquet format needs")
    tables = {"trials": trials, "improvements": improvements}
    return chain(
        ((f"{name}.{kind}", WRITERS[kind](table(results))) for name, table in tables.items()),
        [("environment.json", json.dumps(results.environments, indent=1) + "\n")],
    )


def about(results: StoredResults) -> str:
    """Return the export's README."""
    return readme("tables", budget=results.study.budget_words)


def trials(results: StoredResults) -> pd.DataFrame:
    """Return the tidy frame with texts as ``string`` and counts as ``Int64``, so that neither becomes a float.

    Line ends within an error's text are written as ``\\n``: in a CSV file a lone carriage return would end the row.
    """
    frame = results.frame
    texts = {name: frame[name].astype("string").str.replace(r"\r\n?", "\n", regex=True) for name in TEXTS}
    return frame.assign(**texts, **{name: frame[name].astype("Int64") for name in COUNTS})


def improvements(results: StoredResults) -> pd.DataFrame:
    """Return one row an improvement: problem, optimizer, trial, evaluations (from 1) and the best-so-far value."""
    keys = results.frame[["problem", "optimizer", "trial"]]
    traces = [results.traces.get(key, NO_TRACE) for key in keys.itertuples(index=False, name=None)]
    rows = np.repeat(np.arange(len(keys)), [len(trace.values) for trace in traces])
    improved = keys.iloc[rows].astype({"problem": "string", "optimizer": "string", "trial": np.int64})
    return improved.assign(
        evaluations=np.concatenate([trace.evaluations for trace in traces]),
        value=np.concatenate([trace.values for trace in traces]),
    )


CSV, PARQUET = (FormatWriter(partial(files, kind=kind), about, holds_failures=True) for kind in WRITERS)
