"""What may explain who leads besides the algorithms: options that differ, and budget that was left unused."""

from dataclasses import replace

import numpy as np
import pytest

from bench import Results, Study, Trace
from bench.topics.conditions.differing import differing
from bench.topics.findings import Findings
from tests.bench.reports import store

LEVELS = {"cma-es": 0.0, "gwo": 2.5, "random-search": 40.0}


@pytest.fixture
def made(tmp_path):
    """Return a function that writes a study whose trials end at a level and their number, and returns its findings."""

    def make(optimizers=(), name="s", nfev=None, trials=5):
        study = Study.from_dict({
            "name": name, "trials": trials, "budget": 100,
            "problems": [{"names": ["classical-sphere-d2-i1", "classical-ackley-d3-i1"]}],
            "optimizers": list(optimizers) or [
                {"name": "cma-es", "agents": 9, "handling": "box", "start": "midpoint"}, {"name": "gwo", "agents": 9},
                {"name": "random-search", "agents": 9},
            ],
        })  # fmt: skip
        used = nfev or {}

        def row_of(trial):
            value = LEVELS[trial.optimizer] + trial.number + 10 * ("ackley" in trial.problem)
            dimension = 3 if "ackley" in trial.problem else 2
            return {
                "status": "ok", "fun": value, "nfev": used.get(trial.optimizer, 100), "wall_s": 3.0, "cpu_s": 1.0,
                "objective_s": 0.5, "stop": "tolfun", "outside_box": 0, "x": {f"x{i}": 0.0 for i in range(dimension)},
                "metrics": {}, "trace": Trace(np.array([1]), np.array([value])),
            }  # fmt: skip

        return Findings(Results(store(tmp_path / name, study, row_of, record={"jobs": 2})))

    return make


def explained(findings):
    """Return what may explain that the first one is better than every other one."""
    return differing(findings, findings.final.ranked[1:])


def test_a_budget_that_a_rival_did_not_spend_differs(made):
    assert explained(made(nfev={"gwo": 72})).left == pytest.approx({"gwo": 0.28})
    assert not explained(made(name="t", nfev={"gwo": 99})).left


def test_less_budget_is_not_held_against_the_leader_nor_against_who_needs_no_more(made, monkeypatch):
    assert not explained(made(nfev={"cma-es": 21})).left
    assert not explained(made(name="t", nfev={"cma-es": 21, "gwo": 21})).left
    monkeypatch.setitem(LEVELS, "gwo", 1e-9)  # at the optimum of one of two problems, where it needs no more
    assert explained(made(name="u", nfev={"gwo": 20}, trials=1)).left == pytest.approx({"gwo": 0.4})


def test_unused_budget_explains_a_loss_alone(made):
    """gwo, the subject, beats random-search and loses to cma-es; each of them leaves a part of its budget."""
    wins_and_losses = ["random-search"], ["cma-es"]
    alike = [{"name": name, "agents": 9} for name in LEVELS]

    def explains(name, nfev):
        found = made(optimizers=alike, name=name, nfev=nfev)
        return differing(replace(found, asked_subject="gwo"), *wins_and_losses)

    assert not explains("winner-of-it", {"cma-es": 40})  # it wins although it used less
    assert explains("loser", {"random-search": 40}).left == pytest.approx({"random-search": 0.6})
    assert explains("itself", {"gwo": 40}).left == pytest.approx({"gwo": 0.6})
    assert not explains("both", {"gwo": 40, "cma-es": 40})
