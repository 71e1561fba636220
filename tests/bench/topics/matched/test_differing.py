"""The same conditions in the report: what differs as a clause, chances recomputed by hand, controls in no ranking."""

from dataclasses import replace

import numpy as np
import pytest

from bench import Results, Study, Trace
from bench.topics.findings import Findings
from bench.topics.matched import section as matched
from bench.topics.matched.controls import controls
from bench.topics.matched.differing import Differing, differing
from bench.topics.verdict import section as verdict
from bench.topics.write import write_report
from tests.bench.reports import store

CONTROLS = [
    {"name": "gwo", "label": "gwo (box)", "agents": 9, "handling": "box"},
    {"name": "cma-es", "label": "cma-es (repair, random)", "agents": 9, "handling": "repair", "start": "random"},
]
LEVELS = {"cma-es": 0.0, "gwo": 2.5, "random-search": 40.0, "gwo (box)": 3.5, "cma-es (repair, random)": 4.0}


@pytest.fixture
def made(tmp_path):
    """Return a function that writes a study whose trials end at a level and their number, and returns its findings."""

    def make(controls=CONTROLS, optimizers=(), name="s", nfev=None, trials=5):
        study = Study.from_dict({
            "name": name, "trials": trials, "budget": 100,
            "problems": [{"names": ["classical-sphere-d2-i1", "classical-ackley-d3-i1"]}],
            "optimizers": list(optimizers) or [
                {"name": "cma-es", "agents": 9, "handling": "box", "start": "midpoint"}, {"name": "gwo", "agents": 9},
                {"name": "random-search", "agents": 9},
            ],
        } | ({"controls": list(controls)} if controls else {}))  # fmt: skip
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


def by_hand(first, second):
    """Return A12 of five trials each, whose values are a level and 0 to 4."""
    one, other = (LEVELS[label] + np.arange(5) for label in (first, second))
    return np.mean([(x < y) + 0.5 * (x == y) for x in one for y in other])


def test_each_condition_has_the_chances_of_its_own_runs(made):
    found = made().of(controls).chances.set_index(["conditions", "rival"])
    expected = {
        ("as reported", "gwo"): ("cma-es", "gwo"),
        ("as reported", "random-search"): ("cma-es", "random-search"),
        ("handling = box, start = midpoint", "gwo"): ("cma-es", "gwo (box)"),
        ("handling = repair, start = random", "gwo"): ("cma-es (repair, random)", "gwo"),
        ("handling = repair, start = random", "random-search"): ("cma-es (repair, random)", "random-search"),
    }
    assert {key: tuple(row) for key, row in found[["first", "second"]].T.items()} == expected  # no control, no row
    for key, pair in expected.items():
        assert found.loc[key, "probability"] == pytest.approx(by_hand(*pair))
    assert by_hand("cma-es", "gwo") == pytest.approx(0.76 + 0.12)
    assert by_hand("cma-es (repair, random)", "gwo") < 0.5 < by_hand("cma-es", "gwo (box)")
    assert (found["problems"] == 2).all()
    assert (found["low"] <= found["probability"]).all()


def test_controls_are_in_no_ranking_and_in_no_frame(made):
    findings, without = made(), made(controls=(), name="without")
    assert findings.trials.optimizers == ["cma-es", "gwo", "random-search"]
    for name in ("ranking", "pairs", "overall", "medians"):
        own, other = getattr(findings.final, name), getattr(without.final, name)
        assert own.to_csv() == other.to_csv(), name
    assert findings.anytime.running_times.to_csv() == without.anytime.running_times.to_csv()
    assert not findings.trials.frame["optimizer"].astype(str).str.contains(r"\(").any()
    assert {key[1] for key in findings.trials.traces} == {"cma-es", "gwo", "random-search"}
    assert len(findings.trials.controls) == 2 * 2 * 5


def test_without_shared_conditions_there_is_a_cost_and_no_section(made):
    findings = made(controls=())
    assert matched.section(findings) is None
    assert findings.of(controls).cost == (
        "matched controls (bench run STUDY --matched) would add 30 trials, about 45 s on 2 jobs"
    )
    assert (
        made(controls=(), name="quick")
        .of(controls)
        .cost.startswith("matched controls (bench run quick --matched) would")
    )


def test_one_trial_has_no_interval(made):
    section = matched.section(made(trials=1))
    assert section.items[0].frame.loc["gwo", "as reported"] == "1.00"


def test_nothing_differs_among_equal_conditions(made):
    alike = [{"name": name, "agents": 9} for name in ("gwo", "random-search")]
    findings = made(controls=(), optimizers=alike)
    assert (clause(findings), findings.of(controls).cost, matched.section(findings)) == ("", "", None)


def test_populations_of_one_algorithm_are_conditions_that_need_no_control(made, monkeypatch):
    for label in ("gwo 5", "gwo 9", "random-search 5", "random-search 9"):
        monkeypatch.setitem(LEVELS, label, {"gwo 5": 3.0, "gwo 9": 0.0}.get(label, 1.5))
    both = [
        {"name": name, "label": f"{name} {agents}", "agents": agents}
        for name in ("gwo", "random-search")
        for agents in (5, 9)
    ]
    findings = made(controls=(), optimizers=both)
    found = findings.of(controls).chances.set_index("conditions")
    assert found.loc["as reported", ["first", "rival"]].tolist() == ["gwo 9", "random-search 5"]
    assert found.loc["agents = 5", ["first", "second"]].tolist() == ["gwo 5", "random-search 5"]
    assert found.loc["agents = 5", "probability"] == pytest.approx(by_hand("gwo 5", "random-search 5"))
    assert found.loc["agents = 9", ["first", "second"]].tolist() == ["gwo 9", "random-search 9"]
    assert clause(findings) == ("agents is 5 for gwo 5 and random-search 5 and 9 for the 2 others")


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
    alike = [{"name": name, "agents": 9} for name in LEVELS if "(" not in name]

    def explains(name, nfev):
        found = made(controls=(), optimizers=alike, name=name, nfev=nfev)
        return differing(replace(found, asked_subject="gwo"), *wins_and_losses)

    assert explains("winner-of-it", {"cma-es": 40}) == Differing()  # it wins although it used less
    loser = explains("loser", {"random-search": 40})
    assert loser.clause == "random-search left 60% of its budget unused"
    assert loser.line == "random-search left budget unused: restart it"
    assert loser.remedy == "A restart of random-search would use the rest of the budget."
    assert explains("itself", {"gwo": 40}).clause == "gwo left 60% of its budget unused"
    assert explains("both", {"gwo": 40, "cma-es": 40}) == Differing()


def test_options_that_differ_name_the_run_that_removes_them(made):
    unlike = differing(made(nfev={"gwo": 72}), ["gwo", "random-search"])
    options, budget = unlike.line.split("; gwo ")
    assert options == "handling and start differ; bench run --matched makes them alike"
    assert budget == "left budget unused: restart it"
    assert unlike.remedy.startswith("Under the same conditions it beats gwo with probability ")


def test_what_was_left_unused_is_the_same_number_wherever_the_page_states_it(made, monkeypatch):
    monkeypatch.setitem(LEVELS, "gwo", 1e-9)  # at the optimum of one of two problems, where it leaves nothing
    page = verdict.section(made(name="one", nfev={"gwo": 20}, trials=1))
    said = " ".join(text for card in page.cards for text in card.text)
    assert "gwo left 40% of its budget unused" in said
    assert "before they found the optimum (mean share of all trials): gwo 40%." in said


@pytest.mark.slow
def test_the_page_has_the_table_and_the_trials_of_controls(made, tmp_path):
    findings = made()
    page = write_report(findings.results.paths[0]).read_text(encoding="utf-8")
    assert page.index('id="part.verdict"') < page.index('id="part.under-the-same-conditions"')
    tables = findings.results.paths[0] / "tables"
    assert "gwo (box)" not in (tables / "trials.csv").read_text()
    assert (tables / "controls.csv").read_text().count("\n") == 1 + 2 * 2 * 5
    assert "gwo (box)" in (tables / "same-conditions.csv").read_text()
