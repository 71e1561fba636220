"""Small frames of every kind that can be drawn, and what the tests of drawings share."""

import warnings
from contextlib import contextmanager

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from bench.plots import style

GRID = np.array([1, 2, 5, 10, 20, 50, 99])


@contextmanager
def strict():
    """Draw as a report does, and let no warning through but of letters that the font lacks."""
    with warnings.catch_warnings(), style.context():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="Glyph")
        warnings.filterwarnings("default", category=ResourceWarning)  # of sockets that another test left
        yield


def trials(cells):
    """Return a tidy frame of {(problem, optimizer): values}; an infinite value is a failed trial."""
    rows = [
        {
            "problem": problem, "optimizer": optimizer, "trial": trial, "seed": trial, "nfev": 9,
            "status": "ok" if np.isfinite(value) else "failed", "fun": value if np.isfinite(value) else np.nan,
        }
        for (problem, optimizer), values in cells.items()
        for trial, value in enumerate(values)
    ]  # fmt: skip
    return pd.DataFrame(rows)


def curves(problems, optimizers, median=10.0):
    level = np.where(GRID < 5, np.inf, median)
    parts = [
        pd.DataFrame(
            {"problem": p, "optimizer": o, "evaluations": GRID, "median": level, "q1": level - 1, "q3": level + 1}
        )
        for p in problems
        for o in optimizers
    ]
    return pd.concat(parts, ignore_index=True)


def times(problems, optimizers, unreached=()):
    rows = [
        (p, o, tau, 1.0, 3, 1, np.inf if o in unreached and tau < 0.05 else 10 / tau)
        for p in problems
        for o in optimizers
        for tau in (1.0, 0.5, 0.1, 0.01, 0.001)
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "tau", "target", "trials", "successes", "ert"])


def fractions(optimizers, along="evaluations"):
    parts = [pd.DataFrame({"optimizer": o, along: GRID, "fraction": np.linspace(0, 1, len(GRID))}) for o in optimizers]
    return pd.concat(parts, ignore_index=True)


def axes():
    return Figure().subplots()
