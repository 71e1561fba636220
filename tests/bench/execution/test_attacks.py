"""Optimizers that change what others share, or kill what made them, change no bit of an honest trial.

Their table is in docs/explanation/reliability.md. Other rows of it: hangs, crashes and excess in test_hostile.py,
files, network and other processes in test_sandbox.py, budgets and values beside the objective in test_apart.py, points
that change during the call in tests/bench/test_objective.py, edited rows in tests/bench/cli/test_changed_store.py.
"""

import json
import os
import signal
import sys

import pandas as pd
import pytest

from bench import Results, Study, load_results, run
from bench.execution.job import Task
from bench.execution.supervisor import check

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="processes are forked and supervised as on Linux"),
]

TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb", "study"]
PROBLEMS = ["signature-12", "sphere-3"]
HONEST = [{"name": "gwo", "agents": 6}, {"name": "random-search"}, {"name": "hill-climber"}]
ENDED = "its process or one that it was forked from was ended or stopped twice|with signal SIGKILL twice"
CHANGES = ("replace-gwo", "replace-evaluate", "replace-kernel", "replace-search", "replace-study", "zero-signal")
ONCE = ("kill-parent", "kill-all")  # in one trial


def study(trials, deeds):
    attacks = [{"name": "attack", "label": deed, "deed": deed} for deed in deeds]
    return Study.from_dict(
        {"name": "attacks", "trials": trials, "budget": 60, "problems": [{"names": PROBLEMS}],
         "optimizers": HONEST + attacks}
    )  # fmt: skip


@pytest.fixture(scope="module")
def place(tmp_path_factory, testing_plugins):
    """Two runs: all of them beside honest optimizers, and the honest ones alone."""
    place = tmp_path_factory.mktemp("attacks")
    run(study(4, [*CHANGES, "round-upward", *ONCE]), place / "out", n_jobs=2, timeout=8)
    run(study(4, []), place / "alone", n_jobs=2)
    return place


@pytest.fixture(scope="module")
def frame(place):
    return load_results(place / "out")


def same_bits(one, other):
    frames = (each.drop(columns=TIMES).astype(object) for each in (one, other))
    pd.testing.assert_frame_equal(*frames, check_exact=True, check_like=True)  # in any order of columns


def test_no_bit_of_an_honest_trial_is_changed(place, frame):
    alone = load_results(place / "alone")
    mine = frame[frame["optimizer"].isin(alone["optimizer"])].reset_index(drop=True)
    assert len(mine) == 4 * len(PROBLEMS) * len(HONEST)
    same_bits(mine, alone)
    traces = [Results(place / folder).traces for folder in ("out", "alone")]
    for key, trace in traces[1].items():
        assert traces[0][key].values.tobytes() == trace.values.tobytes()
        assert traces[0][key].evaluations.tobytes() == trace.evaluations.tobytes()


def of(frame, deed):
    rows = frame[frame["optimizer"] == deed]
    assert len(rows) == 4 * len(PROBLEMS)
    return rows


@pytest.mark.parametrize("deed", ONCE)
def test_processes_that_are_killed_are_replaced(frame, deed):
    rows = of(frame, deed)
    attacked = (rows["problem"] == "sphere-3") & (rows["trial"] == 0)
    assert [*rows.loc[attacked, "status"]] == ["failed"]
    assert rows.loc[attacked, "error"].str.contains(ENDED).all(), [*rows.loc[attacked, "error"]]
    assert rows.loc[~attacked, "status"].eq("ok").all()


def test_a_run_whose_own_process_is_killed_leaves_the_names_of_the_trials_under_way(bench, bench_here, tmp_path):
    made = study(2, ["kill-main"])
    (tmp_path / "study.toml").write_text(made.to_toml())
    ended = bench("run", tmp_path / "study.toml", "--output", tmp_path / "out", "--jobs", 1)
    assert ended.returncode == -signal.SIGKILL
    (said,) = [line for line in bench_here("status", tmp_path / "out").stdout.splitlines() if "was killed" in line]
    assert "under way were kill-main on " in said


FORGER = """
import bench.plugins.from_file, bench.study, bench.storage.provenance
from problems.backlash.signature.problem import SignatureFit

SignatureFit.dimension = 99
bench.study.Study.dimensions = lambda self, load: {entry.label: 99 for entry in self.problems}
bench.plugins.observing.modules = lambda: {"forged": "forged.py"}
machine = bench.storage.provenance.machine
bench.storage.provenance.machine = lambda *_: machine() | {"packages": {"numpy": "0.0"}, "host": "forged"}

def mine(objective, rng):
    objective(objective.initial(5))
"""


def test_an_import_forges_nothing_that_is_found_of_others(tmp_path, testing_plugins):
    found = []
    for name, code in (("forger", FORGER), ("other", FORGER[FORGER.index("def") :])):
        (tmp_path / f"{name}.py").write_text(code)
    honest = [{"name": "hill-climber"}, {"name": f"{tmp_path}/other.py:mine", "label": "other"}]
    for optimizers in (honest, [{"name": f"{tmp_path}/forger.py:mine", "label": "forger"}, *honest]):
        made = {"name": "s", "problems": [{"name": "signature-12"}], "optimizers": optimizers}
        found.append(check(Task.of(Study.from_dict(made))))
    (alone, beside) = found
    assert beside.dimensions == alone.dimensions
    modules = {label: files for label, files in beside.present.modules.items() if label != "forger"}
    assert modules == alone.present.modules
    assert json.loads(found[0].machine) == json.loads(found[1].machine)


def test_no_file_is_imported_by_the_command_or_its_report(bench_here, tmp_path):
    code = "import os\nopen(__file__ + '.pids', 'a').write(f'{os.getpid()} ')\n" + FORGER[FORGER.index("def") :]
    (tmp_path / "mine.py").write_text(code)
    optimizers = [{"name": "random-search"}, {"name": f"{tmp_path}/mine.py:mine"}]
    made = {"name": "s", "trials": 2, "budget": 60, "problems": [{"name": "signature-12"}], "optimizers": optimizers}
    (tmp_path / "study.toml").write_text(Study.from_dict(made).to_toml())
    bench_here("run", tmp_path / "study.toml", "--output", tmp_path / "out", "--jobs", 1)
    assert "In your units" in (tmp_path / "out" / "report.html").read_text()
    imported = {int(pid) for pid in (tmp_path / "mine.py.pids").read_text().split()}
    assert len(imported) > 1  # of the check, and of the trials
    assert os.getpid() not in imported
