"""The fits drawn over their recordings, unequal conditions, and the memory of a search, for studies of any shape."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from bench import Results, Study, Trace, load_problem
from bench.analysis import in_study_order
from bench.report.write import save_figure
from bench.storage.folder import Folder
from bench.study import Entry
from problems.backlash.report import fits, fitting_errors, resources
from problems.backlash.signature.model import VARIABLES

X = np.array([-20.0, 0.05, 15.0, 130.0, 0.0, 0.005, 0.15])
FAILED = {"status": "failed", "error": "x"}


def alike(name, agents, **options):
    return Entry(name, f"{name} {agents}", {"agents": agents, "handling": "repair", **options})


def make(folder, optimizers, values, *, datasets=(3, 12), trials=6, x=X, known=True, **options):
    """Write a study whose trials end at ``values(problem, optimizer, trial)``, None for a failure, all at ``x``."""
    problems = tuple(Entry(f"signature-{k:02d}", f"signature-{k:02d}", {"unit": "rpm", **options}) for k in datasets)
    study = Study("s", problems, tuple(optimizers), trials=trials, budget=1000)
    place = Folder(folder)
    place.path.mkdir(parents=True)
    place.claim(study)
    with place.store.writer() as writer:
        for trial in study.plan():
            value = values(trial.problem, trial.optimizer, trial.number)
            row = FAILED if value is None else {
                "status": "ok", "fun": value, "nfev": 400 if trial.optimizer.startswith("cma") else 1000, "wall_s": 1.0,
                "cpu_s": 1.0, "objective_s": 0.5, "stop": "tolfun", "outside_box": 0,
                "x": dict(zip(VARIABLES, (x + 0.001 * trial.number).tolist(), strict=True)) if known else {},
                "metrics": {"amplitude_rpm": 20.0}, "trace": Trace(np.array([1]), np.array([value])),
            }  # fmt: skip
            writer.add(trial, row)
    results = Results(folder)
    return results, in_study_order(results.frame, results.study)


def rising(problem, optimizer, trial):
    return 2.0 + trial + 10 * optimizer.startswith("gwo")


BOTH = [alike("cma-es", 30, start="random"), alike("gwo", 30)]


def test_best_and_median_trial_are_drawn_with_the_recording(tmp_path):
    results, frame = make(tmp_path / "s", BOTH, rising, trials=4)
    shown = fits.shown_trials(frame)
    assert shown[["optimizer", "curve", "trial"]].drop_duplicates().to_numpy().tolist() == [
        [name, curve, trial]
        for name in ("cma-es 30", "gwo 30")
        for curve, trial in (("best trial", 0), ("median trial", 1))
    ]
    ((section,),) = [fits.sections(results, frame)]
    (figure,) = section.items
    data = figure.data
    problem = load_problem("signature-12", unit="rpm")
    signal = data[(data["problem"] == "signature-12") & (data["curve"] == "recording")]
    inside = np.isin(problem.time, signal["time"])
    assert inside.sum() == len(signal) == 100
    assert np.ptp(signal["time"]) == pytest.approx(0.198)
    np.testing.assert_array_equal(signal["speed"], problem.signal[inside])
    best = data[(data["problem"] == "signature-12") & (data["curve"] == "best trial") & (data["optimizer"] == "gwo 30")]
    np.testing.assert_allclose(best["speed"], problem.model(X)[inside], atol=1e-9)
    start = signal["time"].iloc[0] - X[1]
    assert start == pytest.approx(round(start / 0.4) * 0.4, abs=0.002)  # whole turns after t0: A has its sign
    assert figure.shown.loc["signature-03"].tolist() == [2.0, 12.0]


@pytest.mark.parametrize(
    ("change", "values"),
    [
        ({"known": False}, rising),
        ({}, lambda *_: None),
    ],
)
def test_without_a_known_point_nothing_is_drawn(tmp_path, change, values):
    assert fits.sections(*make(tmp_path / "s", BOTH, values, **change)) == []


@pytest.mark.slow
def test_failed_cells_one_trial_one_oscillation_and_a_late_start_are_drawn(tmp_path):
    def values(problem, optimizer, trial):
        return None if (problem, optimizer) == ("signature-03", "gwo 30") else 2.0

    late = np.array([-20.0, 4.79, 15.0, 130.0, 0.0, 0.005, 0.15])
    for number, options in enumerate(({}, {"single": True})):
        results, frame = make(tmp_path / f"{number}", BOTH, values, trials=1, x=late, **options)
        ((section,),) = [fits.sections(results, frame)]
        assert section.items[0].data["problem"].nunique() == 2
        save_figure(section.items[0], tmp_path, "fits")


def test_many_optimizers_and_recordings_are_split_and_counted(tmp_path, monkeypatch):
    monkeypatch.setattr(fits, "ROWS", 2)
    many = [Entry("gwo", f"gwo {number}") for number in range(11)]

    def values(problem, optimizer, trial):
        return 100.0 - int(optimizer.split()[1])

    results, frame = make(tmp_path / "s", many, values, datasets=(3, 4, 5), trials=1)
    (section,) = fits.sections(results, frame)
    assert [figure.name for figure in section.items] == ["fits", "fits-2"]
    assert "Of 11 optimizers, those 8 whose median trials rank lowest" in section.items[0].caption
    assert list(section.items[0].shown) == [f"RMSE of best: gwo {number}" for number in range(3, 11)]


def test_table_7_2_takes_the_thesis_s_population_of_several():
    labels = fitting_errors.algorithms(Study.load("thesis-equal"))
    assert labels == {name: f"{name} 300" for name in ("alo", "goa", "da", "gwo", "cma-es")}


def test_the_memory_of_known_optimizers_and_agents_is_shown(tmp_path):
    study = Study.load("thesis")
    assert resources.memory_of(study).index.tolist() == [entry.label for entry in study.optimizers]
    assert resources.memory_of(Study.load("bbob-quick")).empty
    results, frame = make(tmp_path / "s", [*BOTH, Entry("gwo", "other", {"agents": 31})], rising, trials=1)
    (section,) = resources.sections(frame, results.study)
    assert [item.name for item in section.items] == ["execution-time", "mean-times", "memory"]
    assert section.items[2].frame.index.tolist() == ["cma-es 30", "gwo 30"]
    assert "160 kB with gwo 30 and 340 kB with cma-es 30" in section.text[1]
    assert resources.sections(frame.assign(wall_s=np.nan), results.study) == []


@pytest.mark.parametrize("name", ["gwo", pytest.param("cma-es", marks=pytest.mark.slow)])
def test_the_memory_that_reports_print_is_what_is_measured(name):
    code = f"import memory; print(1e3 * memory.memory({name!r}, 300, 60_000, 0, True)[1])"
    place = Path(__file__).resolve().parents[4] / "performance"
    done = subprocess.run([sys.executable, "-c", code], cwd=place, capture_output=True, text=True, check=True)
    printed = resources.measured().set_index(["optimizer", "agents"]).loc[(name, 300), "traced_kb"]
    assert float(done.stdout) == pytest.approx(printed, rel=0.3)


def test_a_study_of_unequal_conditions_names_the_one_of_equal_ones():
    assert "the study thesis-equal does so with several populations" in fitting_errors.unequal(Study.load("thesis"))[0]
    assert fitting_errors.unequal(Study.load("thesis-equal")) == ()
