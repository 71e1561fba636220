"""The best fit of each recording in a report, and which trials found it."""

import math
from functools import cache

import pytest

from bench import Results, Study, load_problem
from bench.study import Entry
from bench.topics import Findings, repairing
from problems.backlash.report import sections
from problems.backlash.report import units as on_backlash
from tests.bench import reports

CMA, GWO = Entry("cma-es", "cma", {"handling": "box"}), Entry("gwo", "wolves")
FAILED = math.inf


@cache
def best(level, *, constrained=False):
    """The RMSE of the best fit in rpm."""
    return load_problem(f"signature-{level:02d}", unit="rpm").reference(constrained=constrained).value


def make(folder, found, *, datasets=(3, 12), optimizers=(CMA, GWO), unit="rpm"):
    """Write a study whose trials end at ``found[label]`` times the best fit, one factor a trial.

    The fit is that in the box for cma, and that under the constraints for the others.
    """
    problems = tuple(Entry(f"signature-{k:02d}", f"set {k}", {"unit": unit}) for k in datasets)
    study = Study("s", problems, optimizers, trials=len(next(iter(found.values()))))

    def row_of(trial):
        factor = found[trial.optimizer][trial.number]
        value = factor * best(int(trial.problem[4:]), constrained=trial.optimizer != "cma")
        return reports.FAILED if factor == FAILED else reports.ended(value, metrics={"amplitude_rpm": 30.0})

    return Results(reports.store(folder, study, row_of))


def section(results):
    return on_backlash(Findings(results))


def table(found):
    return next(item.frame for item in found.items if item.name == "found")


def test_a_trial_is_measured_against_the_best_fit_under_what_it_ran_under(tmp_path):
    found = {"cma": [1.0, 1.0095, 1.0105, FAILED], "wolves": [1.0, 1.0095, 1.0135, 2.0]}
    shown = section(make(tmp_path / "s", found))
    overall = table(shown)
    assert overall["ran under"].tolist() == ["box", "constraints"]
    assert overall["best fit found %"].tolist() == [50, 50]
    assert overall.loc["cma", "median regret %"] == pytest.approx(100 * (0.0095 + 0.0105) / 2)
    assert overall.loc["wolves", "median regret %"] == pytest.approx(100 * (0.0095 + 0.0135) / 2)
    assert "50% of cma runs and 50% of wolves runs ended within 1% of the best fit" in shown.text[0]
    cost = max(best(level, constrained=True) / best(level) - 1 for level in (3, 12))
    said = f"under which wolves ran, raise the best error on 2 of 2 datasets, by {100 * cost:.1f}% at most."
    assert said in shown.text[1]


@pytest.mark.parametrize(
    ("entry", "constrained"),
    [
        (CMA, False), (GWO, True), (Entry("cma-es", "a"), True), (Entry("gwo", "b", {"handling": "box"}), False),
        (Entry("missing", "c", {"handling": "box"}), False), (Entry("missing", "d"), True),
    ],
)  # fmt: skip
def test_who_kept_to_the_constraints_is_told_by_the_handling_also_without_the_plug_in(entry, constrained):
    assert repairing(Study("s", (), (entry,))) == {entry.label: constrained}


def test_the_first_screen_has_the_shares_of_the_best_fit(tmp_path):
    first, _ = sections(
        Findings(make(tmp_path / "s", {"cma": [1.0, 1.0, 1.001, 2.0], "wolves": [1.0, 1.0, 2.0, FAILED]}))
    )
    assert first.lines[0].text == "cma finds the best fit in 75% of its runs, wolves 50%"
