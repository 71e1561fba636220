"""The best fit of each recording in a report, and which trials found it."""

import math

import numpy as np
import pytest

from bench import Results, Study, load_problem
from bench.study import Entry
from bench.topics import Findings, repairing
from problems.backlash.report import shares
from problems.backlash.report import units as on_backlash
from problems.backlash.signature.problem import Fit, SignatureFit
from tests.bench import reports
from tests.bench.storage.filled import change_data

BOX, CONSTRAINED = 2.0, 2.2  # rpm, the RMSE of the best fit
CMA, GWO = Entry("cma-es", "cma", {"handling": "box"}), Entry("gwo", "wolves")
FAILED = math.inf


@pytest.fixture(autouse=True)
def best_fit(monkeypatch):
    """The best fit has the expected A but for 1 rpm, and is 10 % worse under the constraints but on dataset 5."""

    def stub(self, *, constrained=False):
        x = np.array([1.0 - self.expected["amplitude_rpm"][0], 0.1, 15.0, 130.0, 0.0, 0.01, 0.1])
        return Fit(x, CONSTRAINED if constrained and self.name != "signature-05" else BOX)

    monkeypatch.setattr(SignatureFit, "reference", stub)


def make(folder, found, *, datasets=(3, 12), optimizers=(CMA, GWO), unit="rpm"):
    """Write a study whose trials end at ``found[label]``, one RMSE a trial."""
    problems = tuple(Entry(f"signature-{k:02d}", f"set {k}", {"unit": unit}) for k in datasets)
    study = Study("s", problems, optimizers, trials=len(next(iter(found.values()))))

    def row_of(trial):
        value = found[trial.optimizer][trial.number]
        return reports.FAILED if value == FAILED else reports.ended(value, metrics={"amplitude_rpm": 30.0})

    return Results(reports.store(folder, study, row_of))


def section(results):
    return on_backlash(Findings(results))


def table(found):
    return next(item.frame for item in found.items if item.name == "found")


def test_a_trial_is_measured_against_the_best_fit_under_what_it_ran_under(tmp_path):
    found = {"cma": [2.0, 2.019, 2.021, FAILED], "wolves": [2.0, 2.221, 2.23, 4.4]}
    shown = section(make(tmp_path / "s", found))
    overall = table(shown)
    assert overall["ran under"].tolist() == ["box", "constraints"]
    assert overall["best fit found %"].tolist() == [50, 50]
    assert overall.loc["cma", "median regret %"] == pytest.approx(100 * (0.0095 + 0.0105) / 2)
    assert overall.loc["wolves", "median regret %"] == pytest.approx(100 * (2.2255 / 2.2 - 1))
    assert "50% of cma runs and 50% of wolves runs ended within 1% of the best fit" in shown.text[0]


def test_what_the_constraints_cost_the_best_fit_is_said(tmp_path):
    found = {"cma": [2.0], "wolves": [3.0]}
    cost = section(make(tmp_path / "s", found, datasets=(3, 5))).text[1]
    assert "under which wolves ran, raise the best error on 1 of 2 datasets, by 10.0% at most." in cost
    free = section(make(tmp_path / "t", found, datasets=(5,))).text[1]
    assert "do not raise the best error on any of 1 dataset" in free


def test_without_an_optimizer_under_the_constraints_nothing_is_said_of_them(tmp_path):
    shown = section(make(tmp_path / "s", {"cma": [2.0]}, optimizers=(CMA,), datasets=(3,)))
    assert "constraints" not in " ".join(shown.text)


@pytest.mark.parametrize(
    ("entry", "constrained"),
    [
        (CMA, False), (GWO, True), (Entry("cma-es", "a"), True), (Entry("gwo", "b", {"handling": "box"}), False),
        (Entry("missing", "c", {"handling": "box"}), False), (Entry("missing", "d"), True),
    ],
)  # fmt: skip
def test_who_kept_to_the_constraints_is_told_by_the_handling_also_without_the_plug_in(entry, constrained):
    assert repairing(Study("s", (), (entry,))) == {entry.label: constrained}


def test_a_problem_whose_data_changed_is_left_out(tmp_path):
    make(tmp_path / "s", {"cma": [2.0], "wolves": [2.0]})
    change_data(tmp_path / "s", {"set 3": "of other data"})
    shown = section(Results(tmp_path / "s"))
    assert table(shown)["best fit found %"].tolist() == [100, 100]
    assert "The expected values of set 3 are not known" in shown.lines[0].text


def test_the_first_screen_has_the_shares_of_the_best_fit_and_of_amplitude_and_gap_within_their_bands(tmp_path):
    truth = {k: load_problem(f"signature-{k:02d}").expected for k in (3, 12)}
    problems = tuple(Entry(f"signature-{k:02d}", f"set {k}", {"unit": "rpm"}) for k in truth)

    def row_of(trial):
        if trial.optimizer == "wolves" and trial.number == 3:
            return reports.FAILED
        off = 5.0 if trial.number == 2 else 0.5
        (amplitude, _), (gap, _) = (truth[int(trial.problem[-2:])][name] for name in ("amplitude_rpm", "backlash_rad"))
        far = 3e-4 if trial.number else 0.0
        return reports.ended(BOX + off - 0.5, metrics={"amplitude_rpm": amplitude - off, "backlash_rad": gap + far})

    results = Results(reports.store(tmp_path / "s", Study("s", problems, (CMA, GWO), trials=4), row_of))
    made = shares.shares(results)
    assert made.columns.tolist() == ["best fit", "amplitude within the band", "gap within the band"]
    assert made.loc["cma"].tolist() == [0.75, 0.75, 0.25]
    assert made.loc["wolves"].tolist() == [0.5, 0.5, 0.25]
