"""Statistics of a study in which some optimizers cannot reach the optimum of a problem."""

from dataclasses import replace

import numpy as np
import pytest

from bench.contract.objective import Trace
from bench.results.results import ProblemFacts
from bench.topics.findings import Findings
from tests.bench.made import Known


@pytest.fixture
def findings(make, tmp_path):
    """Return a study in which a searches the box and b repairs; b ends at the best of the repaired points of p."""
    changes = {"a": {"fun": 5.0}, "b": {"fun": 6.0}}
    options = {"a": {"handling": "box"}, "b": {"handling": "repair"}}
    folder = make(tmp_path / "s", ("p",), ("a", "b"), trials=6, changes=changes, options=options)
    found = Findings(Known(folder, lambda label: ProblemFacts(5.0, repaired_optimum=6.0)), [0.5, 1e-3])
    ends = {"a": 5.0, "b": 6.0}
    traces = {("p", o, i): Trace(np.array([1, 50]), np.array([9.0, ends[o]])) for o in "ab" for i in range(6)}
    found.trials.__dict__["pooled"] = replace(found.trials.pooled, traces=traces)
    return found


def test_regret_targets_and_running_times_take_the_optimum_that_an_optimizer_can_reach(findings):
    assert findings.trials.shifts == {("p", "b"): 1.0}
    assert findings.trials.measured.groupby("optimizer", observed=True)["fun"].max().to_dict() == {"a": 5.0, "b": 5.0}
    assert findings.trials.unbeaten == {"p": 5.0}
    hits = findings.anytime.hits(["a", "b"])
    assert np.isfinite(hits.loc[hits["tau"] == 1e-3, "evaluations"]).all()
    assert np.isfinite(findings.anytime.running_times["ert"].to_numpy(dtype=float)).all()
    assert findings.final.measured_summary["best"].tolist() == [5.0, 5.0]


def test_ranks_medians_and_tests_compare_the_values_themselves(findings):
    assert findings.trials.frame is findings.trials.whole
    assert findings.final.summary["median"].tolist() == [5.0, 6.0]
    assert findings.final.chances.set_index("optimizer")["rank"].to_dict() == {"a": 1.0, "b": 2.0}
