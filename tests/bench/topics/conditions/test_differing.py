"""What may explain who leads besides the algorithms: options that differ, and budget that was left unused."""

from dataclasses import replace

import numpy as np
import pytest

from bench import Results, Study, Trace
from bench.topics.conditions.differing import Differing, differing
from bench.topics.findings import Findings
from bench.topics.verdict import section as verdict
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


def clause(findings):
    """Return what may explain that the first one is better than every other one."""
    return differing(findings, findings.final.ranked[1:]).clause


def test_nothing_differs_among_equal_conditions(made):
    alike = [{"name": name, "agents": 9} for name in ("gwo", "random-search")]
    assert clause(made(optimizers=alike)) == ""


def test_a_budget_that_a_rival_did_not_spend_differs(made):
    stopped = made(nfev={"gwo": 72})
    assert clause(stopped).endswith("for the 2 others, gwo left 28% of its budget unused")
    assert "unused" not in clause(made(name="t", nfev={"gwo": 99}))


def test_less_budget_is_not_held_against_the_leader_nor_against_who_needs_no_more(made, monkeypatch):
    assert "unused" not in clause(made(nfev={"cma-es": 21}))
    assert "unused" not in clause(made(name="t", nfev={"cma-es": 21, "gwo": 21}))
    monkeypatch.setitem(LEVELS, "gwo", 1e-9)  # at the optimum of one of two problems, where it needs no more
    assert clause(made(name="u", nfev={"gwo": 20}, trials=1)).endswith("gwo left 40% of its budget unused")


def test_unused_budget_explains_a_loss_alone(made):
    """gwo, the subject, beats random-search and loses to cma-es; each of them leaves a part of its budget."""
    wins_and_losses = ["random-search"], ["cma-es"]
    alike = [{"name": name, "agents": 9} for name in LEVELS]

    def explains(name, nfev):
        found = made(optimizers=alike, name=name, nfev=nfev)
        return differing(replace(found, asked_subject="gwo"), *wins_and_losses)

    assert explains("winner-of-it", {"cma-es": 40}) == Differing()  # it wins although it used less
    loser = explains("loser", {"random-search": 40})
    assert loser.clause == "random-search left 60% of its budget unused"
    assert loser.line == "random-search left budget unused: restart it"
    assert loser.remedy == "A restart of random-search would use the rest of the budget."
    assert explains("itself", {"gwo": 40}).clause == "gwo left 60% of its budget unused"
    assert explains("both", {"gwo": 40, "cma-es": 40}) == Differing()


def test_options_that_differ_are_named_with_what_makes_them_alike(made):
    unlike = differing(made(nfev={"gwo": 72}), ["gwo", "random-search"])
    options, budget = unlike.line.split("; gwo ")
    assert options == "handling and start differ: set them alike in the study"
    assert budget == "left budget unused: restart it"
    assert unlike.remedy == (
        "Set handling and start alike in the study to compare the algorithms alone. "
        "A restart of gwo would use the rest of the budget."
    )


def test_what_was_left_unused_is_the_same_number_wherever_the_page_states_it(made, monkeypatch):
    monkeypatch.setitem(LEVELS, "gwo", 1e-9)  # at the optimum of one of two problems, where it leaves nothing
    page = verdict.section(made(name="one", nfev={"gwo": 20}, trials=1))
    said = " ".join(text for card in page.cards for text in card.text)
    assert "gwo left 40% of its budget unused" in said
    assert "before they found the optimum (mean share of all trials): gwo 40%." in said
