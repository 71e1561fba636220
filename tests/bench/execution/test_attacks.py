"""Optimizers that attack others, the harness or their own record win nothing and change no bit of an honest trial.

Their table is in docs/explanation/isolation.md. Other rows of it: hangs, crashes and excess in test_hostile.py, files,
network and other processes in test_sandbox.py, budgets and values beside the objective in test_strict.py, points that
change during the call in tests/bench/test_objective.py, edited rows in tests/bench/cli/test_changed_store.py.
"""

import json
import os
import signal
import sys

import pandas as pd
import pytest

from bench import Results, Study, load_problem, load_results, run
from bench.execution.job import Task
from bench.execution.supervisor import check
from bench.plugins.from_file import contents, fingerprint

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="processes are forked and supervised as on Linux"),
]

TIMES = ["wall_s", "cpu_s", "objective_s", "study"]
PROBLEMS = ["signature-12", "sphere-3"]
HONEST = [{"name": "gwo", "agents": 6}, {"name": "random-search"}, {"name": "hill-climber"}]
REFUSED, NO_ANSWER = "its answer is refused: ", "it sent what answers no call"
FALSE = f"{REFUSED}its best value is"
ENDED = "its process or one that it was forked from was ended or stopped twice|with signal SIGKILL twice"

CLAIMS = {  # fail in every trial
    "send-pickle": NO_ANSWER,
    "send-pickled-value": NO_ANSWER,
    "send-pair": NO_ANSWER,
    "send-number": f"{REFUSED}it is no table of fields",
    "send-nothing": f"{REFUSED}its nfev is no whole number",
    "send-text": f"{REFUSED}its fun is no number",
    "send-altered": f"{REFUSED}its error is no text|{NO_ANSWER}",  # the true answer arrives in the next trial
    "claim-value": f"{REFUSED}its trace ends at",
    "claim-trace": FALSE,
    "claim-budget": f"{REFUSED}it stopped by 'budget' after 5 of 60",
    "raise-budget": f"{REFUSED}it made 600 evaluations, of a budget of 60",
}
ONCE = {  # attack in one trial
    "notes": ("timeout", "after 8 s, the limit of a trial"),
    "kill-parent": ("failed", ENDED),
    "kill-all": ("failed", ENDED),
}
CHANGES = ("replace-gwo", "replace-evaluate", "replace-kernel", "replace-search", "replace-study", "zero-signal")
ROUNDING = "round-upward"
WINNING = {  # where what is changed would pay
    "replace-evaluate": (PROBLEMS, FALSE),
    "replace-kernel": (["signature-12"], FALSE),
    "replace-search": (PROBLEMS, f"{REFUSED}its trace ends at .*, its best value is 0.0"),
    "zero-signal": (["signature-12"], "ZeroDivisionError"),
}


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
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MARKER", str(place / "marker"))
        run(study(4, [*CHANGES, ROUNDING, *CLAIMS, *ONCE]), place / "out", n_jobs=2, timeout=8)
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


@pytest.mark.parametrize("deed", CLAIMS)
def test_what_is_claimed_or_sent_in_place_of_an_answer_fails_with_the_reason(frame, deed):
    rows = of(frame, deed)
    assert rows["status"].eq("failed").all()
    assert rows["error"].str.contains(CLAIMS[deed]).all(), [*rows["error"]]


def test_nothing_is_unpickled_from_a_trial_process(place):
    assert not (place / "marker").exists()


@pytest.mark.parametrize("deed", ONCE)
def test_signs_of_life_prolong_no_trial_and_lost_processes_are_replaced(frame, deed):
    rows, (status, words) = of(frame, deed), ONCE[deed]
    attacked = (rows["problem"] == "sphere-3") & (rows["trial"] == 0)
    assert [*rows.loc[attacked, "status"]] == [status]
    assert rows.loc[attacked, "error"].str.contains(words).all(), [*rows.loc[attacked, "error"]]
    assert rows.loc[~attacked, "status"].eq("ok").all()


@pytest.mark.parametrize("deed", [*CHANGES, ROUNDING])
def test_what_is_changed_in_memory_wins_nothing(frame, deed):
    rows = of(frame, deed)
    for name in PROBLEMS:
        problem = load_problem(name)
        mine = rows[(rows["problem"] == name) & (rows["status"] == "ok")]
        points = mine[[f"x_{variable}" for variable in problem.variables]].to_numpy()
        assert points.shape[1] == problem.dimension
        values = [problem.evaluate(point[None])[0] for point in points]
        assert mine["fun"].to_numpy() == pytest.approx(values, rel=1e-9)
    if deed in WINNING:
        on, words = WINNING[deed]
        lost = rows[rows["problem"].isin(on)]
        assert lost["error"].str.contains(words).all(), [*lost["error"]]


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

SignatureFit.fingerprint = lambda self: "forged"
bench.study.Study.data = lambda self: {entry.label: "forged" for entry in self.problems}
bench.study.Study.code = lambda self, labels: {entry.label: "forged" for entry in self.optimizers}
bench.plugins.from_file.fingerprint = lambda name: "forged"
machine = bench.storage.provenance.machine
bench.storage.provenance.machine = lambda *_: machine() | {"packages": {"numpy": "0.0"}, "host": "forged"}

def mine(objective, rng):
    objective(objective.initial(5))
"""


def test_an_import_forges_no_fingerprint(tmp_path, testing_plugins):
    found = []
    for name, code in (("forger", FORGER), ("other", FORGER[FORGER.index("def") :])):
        (tmp_path / f"{name}.py").write_text(code)
    honest = [{"name": "hill-climber"}, {"name": f"{tmp_path}/other.py:mine", "label": "other"}]
    for optimizers in (honest, [{"name": f"{tmp_path}/forger.py:mine", "label": "forger"}, *honest]):
        made = {"name": "s", "problems": [{"name": "signature-12"}], "optimizers": optimizers}
        found.append(check(Task.of(Study.from_dict(made))))
    (alone, beside) = (each.fingerprints for each in found)
    assert beside.data == alone.data
    forger = f"{tmp_path}/forger.py:mine"
    assert beside.code == alone.code | {"forger": fingerprint(forger, contents([forger]))}
    assert json.loads(found[0].machine) == json.loads(found[1].machine)


def test_no_file_is_imported_by_the_command_or_its_report(bench_here, tmp_path):
    code = "import os\nopen(__file__ + '.pids', 'a').write(f'{os.getpid()} ')\n" + FORGER[FORGER.index("def") :]
    (tmp_path / "mine.py").write_text(code)
    optimizers = [{"name": "random-search"}, {"name": f"{tmp_path}/mine.py:mine"}]
    made = {"name": "s", "trials": 2, "budget": 60, "problems": [{"name": "signature-12"}], "optimizers": optimizers}
    (tmp_path / "study.toml").write_text(Study.from_dict(made).to_toml())
    bench_here("run", tmp_path / "study.toml", "--output", tmp_path / "out", "--jobs", 1)
    assert "Reference fit" in (tmp_path / "out" / "report.html").read_text()
    imported = {int(pid) for pid in (tmp_path / "mine.py.pids").read_text().split()}
    assert len(imported) > 1  # of the check, and of the trials
    assert os.getpid() not in imported
