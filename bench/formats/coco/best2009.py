"""Read the best of 2009, COCO's reference on ``bbob`` and ``bbob-noisy``, from the installed package ``cocopp``.

It is no algorithm: for each function, dimension and precision it holds the lowest expected running time (ERT) of any
algorithm of the BBOB workshop of 2009, whichever that was. cocopp (BSD licence) carries it in COCO's format, with the
ERT in place of the evaluations of one artificial run; nothing of it is copied here, and cocopp is not imported.

Source: N. Hansen, A. Auger, R. Ros, S. Finck, P. Pošík, "Comparing results of 31 algorithms from the black-box
optimization benchmarking BBOB-2009", GECCO 2010 (companion), doi:10.1145/1830761.1830790.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

import pandas as pd

from bench.contract.families import function_of
from bench.formats import naming
from bench.formats.coco import reader
from bench.formats.source import opened
from bench.helpers.errors import BenchError

NAME = "best2009"
SUITES = ("bbob", "bbob-noisy")
COLUMNS = ["problem", "precision", "ert"]


def best2009(names: Iterable[str]) -> pd.DataFrame:
    """Return the ERT of the best of 2009 on the functions of these problems: problem, precision and ert.

    ``problem`` is a function in a dimension, such as ``"bbob-f08-d5"``, and ``ert`` is in evaluations. Precisions fall
    to 1e-8, five a decade; those that no algorithm reached are left out.

    Args:
        names: of problems, with or without instance, such as ``"bbob-f08-d5-i1"``.

    Raises:
        BenchError: where cocopp is missing or holds no such data, and where none of the names has any.
    """
    wanted = {function_of(name) for name in names}
    suites = [suite for suite in SUITES if any(name.startswith(f"{suite}-f") for name in wanted)]
    tables = [table[table["problem"].isin(wanted)] for table in map(_suite, suites)]
    if not any(map(len, tables)):
        raise BenchError(
            f"{NAME} has running times on {' and '.join(SUITES)} in 2, 3, 5, 10, 20 and 40 dimensions, and the study "
            "has no such problem; leave out this reference and targets by running length"
        )
    return pd.concat(tables, ignore_index=True)


@cache
def _suite(suite: str) -> pd.DataFrame:
    """Return the table of a suite."""
    path = _package() / "refalgs" / f"{NAME}-{suite}.tar.gz"
    if not path.is_file():
        raise BenchError(f"the installed cocopp has no {path.name}; install another with: {_INSTALL}")
    rows = []
    with opened(path) as source:
        indices = (file for file in source.files if reader.is_index(source, file))
        for data in chain.from_iterable(reader.indexed(source, file) for file in indices):
            problem = function_of(naming.problem_name(data.suite, int(data.function), data.dimension, 1))
            for log, _ in data.logs:
                for block in reader.logged(source, log):
                    rows.append(pd.DataFrame({"problem": problem, "precision": block.values, "ert": block.evaluations}))
    return pd.concat(rows, ignore_index=True).astype({"ert": float})


_INSTALL = "pip install 'backlash-bench[coco]'"


def _package() -> Path:
    """Return the folder of cocopp."""
    spec = find_spec("cocopp")
    if spec is None or spec.origin is None:
        raise BenchError(f"{NAME} is read from cocopp, which is not installed; install it with: {_INSTALL}")
    return Path(spec.origin).parent
