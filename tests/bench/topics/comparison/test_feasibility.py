"""The section on feasibility: there only for constrained problems whose constraints were handled."""

from dataclasses import replace

import numpy as np
import pytest

from bench import BenchError, Results, Study
from bench.objective import Trace
from bench.storage.folder import Folder
from bench.study import Entry
from bench.topics.comparison import feasibility
from bench.topics.findings import Findings
from tests.bench.reports import finished, store

NONE = {"fun": np.inf, "trace": Trace(np.array([], dtype=np.int64), np.array([]))}


def written(path):
    """Write a study on a problem with constraints and one without, where trial 0 of scatter found no feasible point."""
    problems, optimizers = (
        tuple(Entry(each, each) for each in labels) for labels in (("ring-2", "sphere-2"), ("scatter", "early"))
    )
    study = Study("made", problems, optimizers, trials=4, budget=100)
    rng = np.random.default_rng(0)

    def row_of(trial):
        return finished(10.0, rng) | (NONE if trial.key == ("ring-2", "scatter", 0) else {})

    return Findings(Results(store(path, study, row_of)))


def test_without_handled_constraints_there_is_none(testing_plugins, make, tmp_path):
    assert feasibility.sections(Findings(Results(make(tmp_path / "s")))) == ()


def test_two_handlings_are_not_compared(testing_plugins, tmp_path):
    """As their values mean the same, but their optimizers saw other problems."""
    written(tmp_path / "one")
    other = written(tmp_path / "two").results.study
    Folder(tmp_path / "two").claim(replace(other, constraints="death"))
    with pytest.raises(BenchError, match="handles constraints by 'lexicographic' and 'made' by 'death'"):
        Results(tmp_path / "one", tmp_path / "two")
