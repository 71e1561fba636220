"""Values that count from the optimum that an optimizer can reach, by hand."""

import numpy as np
import pandas as pd

from bench.analysis.own_optimum import ShiftedTraces, shifted, shifts
from bench.contract.objective import Trace

ROWS = [("p", "box", 1.0), ("p", "repair", 1.5), ("q", "box", 2.0), ("q", "repair", 2.0), ("q", "repair", None)]
FRAME = pd.DataFrame(ROWS, columns=["problem", "optimizer", "fun"]).assign(
    trial=[0, 0, 0, 0, 1], status=["ok"] * 4 + ["failed"]
)


def test_only_cells_that_cannot_reach_the_optimum_are_shifted():
    by = shifts(FRAME, {"p": 1.0, "q": 2.0}, {"p": 1.5}, ["repair"])
    assert by == {("p", "repair"): 0.5}
    assert shifted(FRAME, by)["fun"].tolist()[:4] == [1.0, 1.0, 2.0, 2.0]
    assert FRAME["fun"].tolist()[1] == 1.5
    traces = {("p", each, 0): Trace(np.array([1, 7]), np.array([4.0, 1.5])) for each in ("box", "repair")}
    found = ShiftedTraces(traces, by)
    assert found["p", "repair", 0].values.tolist() == [3.5, 1.0]
    assert found["p", "box", 0].values.tolist() == [4.0, 1.5]
    assert found.get(("q", "box", 0)) is None
    assert [*found] == [*traces]
    assert len(found) == 2
    assert shifted(FRAME, {}) is FRAME
