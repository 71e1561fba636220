"""The best fit of each recording in a report, and which trials found it."""

import math

import numpy as np
import pytest

from bench import Results, Study, load_problem
from bench.report.write import save_table
from bench.study import Entry
from bench.topics import Findings, repairing
from problems.backlash.report import reference, sections, shares
from problems.backlash.signature.problem import TOLERANCE_RPM, Fit, SignatureFit
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
    (found,) = [each for each in sections(Findings(results)) if each.title == reference.TITLE]
    return found


def table(found, name):
    return next(item.frame for item in found.items if item.name == name)


def test_a_trial_is_measured_against_the_best_fit_under_what_it_ran_under(tmp_path):
    found = {"cma": [2.0, 2.019, 2.021, FAILED], "wolves": [2.0, 2.221, 2.23, 4.4]}
    shown = section(make(tmp_path / "s", found))
    overall = table(shown, "reference-fit-by-optimizer")
    assert overall["ran under"].tolist() == ["box", "constraints"]
    assert overall["trials"].tolist() == [8, 8]
    assert overall["found %"].tolist() == [50, 50]
    assert overall.loc["cma", "median regret %"] == pytest.approx(100 * (0.0095 + 0.0105) / 2)
    assert overall.loc["wolves", "median regret %"] == pytest.approx(100 * (2.2255 / 2.2 - 1))
    assert table(shown, "reference-fit-found").loc["set 12"].to_dict() == {"cma": 50, "wolves": 50}
    assert "50% of cma trials and 50% of wolves trials ended within 1% of the optimum." in shown.text[0]


def test_what_the_constraints_cost_the_best_fit_is_said(tmp_path):
    found = {"cma": [2.0], "wolves": [3.0]}
    shown = section(make(tmp_path / "s", found, datasets=(3, 5)))
    assert "under which wolves ran, raise the best RMSE on 1 of 2 datasets, by 10.0% at most." in shown.text[1]
    assert "do not raise the best RMSE on any dataset" in section(make(tmp_path / "t", found, datasets=(5,))).text[1]


def test_the_best_fit_of_each_dataset_stands_beside_the_truth(tmp_path):
    shown = section(make(tmp_path / "s", {"cma": [2.0], "wolves": [3.0]}))
    fits = table(shown, "reference-fit")
    expected = load_problem("signature-12").expected["amplitude_rpm"][0]
    assert fits.loc["set 12"].tolist() == pytest.approx([BOX, CONSTRAINED, expected - 1, expected - 1, expected])
    assert f"within ±{TOLERANCE_RPM:.4f} rpm of the expected one on 2 of 2 datasets" in shown.text[2]
    assert "A fit determines |A| to 3.0% only" in shown.text[2]  # exp(15 / s * 0.002 s)
    for item in shown.items:
        save_table(item, tmp_path, item.name)


def test_without_an_optimizer_under_the_constraints_nothing_is_said_of_them(tmp_path):
    shown = section(make(tmp_path / "s", {"cma": [2.0]}, optimizers=(CMA,), datasets=(3,)))
    assert list(table(shown, "reference-fit")) == ["RMSE in the box", "|A| in the box", "expected |A|"]
    assert "constraints" not in " ".join(shown.text)


def test_the_authors_own_runs_stand_beside_those_of_cma_es_on_dataset_12(tmp_path):
    assert sum(reference.AUTHORS.values()) == 30
    shown = section(make(tmp_path / "s", {"cma": [2.0, 5.0], "wolves": [2.0, 2.0]})).text[-1]
    assert "0.0533 rps, in 10 runs (33%), at 0.1590 rps in 18, at 0.1892 rps in 1 and at 0.1229 rps in 1." in shown
    assert "Here 50% of cma trials on set 12 found it." in shown
    other = section(make(tmp_path / "t", {"cma": [2.0], "wolves": [2.0]}, datasets=(3,)))
    swarm = section(make(tmp_path / "u", {"wolves": [2.0]}, optimizers=(GWO,)))
    assert not any("authors" in text for each in (other, swarm) for text in each.text)


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
    assert table(shown, "reference-fit").index.tolist() == ["set 12"]
    assert table(shown, "reference-fit-by-optimizer")["trials"].tolist() == [1, 1]


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
