"""Decide from the stored trials which cells of a study with declared looks need no more trials."""

from __future__ import annotations

from math import comb

from bench.storage.store import Store
from bench.study import Study

_COLUMNS = ("problem", "optimizer", "trial", "status", "fun")


def blind_looks(study: Study) -> list[int]:
    """Return the study's looks that can decide nothing."""
    if not study.looks:
        return []
    from bench.analysis import looks

    tests = comb(len(study.optimizers), 2) * len(study.problems)
    return looks.blind_looks(study.looks, tests)


def stopped_cells(study: Study, store: Store) -> dict[tuple[str, str], int]:
    """Return the number of trials at which each cell (problem, optimizer) was stopped, for those that were.

    It follows from the stored trials alone (:func:`bench.analysis.looks.decide`), so an interrupted run continues with
    the same decisions.
    """
    if not study.looks:
        return {}
    import pandas as pd  # a run without looks needs neither

    from bench.analysis.cells import in_study_order
    from bench.analysis.looks import decide

    compared = {entry.label for entry in study.optimizers}
    rows = pd.DataFrame(store.rows(columns=_COLUMNS), columns=list(_COLUMNS))
    rows = rows[rows["optimizer"].isin(compared)]
    return dict(decide(in_study_order(rows, study), study.looks).stopped)
