"""State between trials: the warm-up sees no problem, and each run makes a trial of each optimizer again."""

import pytest

from bench import BenchError, Results, Study, load_results, run
from bench.execution.again import by_the_clock
from bench.execution.runner import plan
from bench.execution.verify import verify
from bench.storage.folder import VERIFICATION, Folder

LEARNS = """
best = {}

def learns(objective, rng):
    key = objective.dimension, objective.budget
    best.setdefault(key, (float("inf"), None))
    while True:
        x = objective.initial(1)[0] if best[key][1] is None else best[key][1] * 0.9
        f = objective(x)
        if f < best[key][0]:
            best[key] = f, x

def honest(objective, rng):
    while True:
        objective(objective.initial(10))

seen = []

def remembers(objective, rng):
    seen.append(objective.lower.tolist())
    objective.stop(repr(len(seen)))
    seen.append(objective(objective.lower))
    objective(objective.initial(1) if seen[1] == 50.0 else objective.lower * 0)
"""


@pytest.fixture
def file(tmp_path):
    (tmp_path / "mine.py").write_text(LEARNS)
    return tmp_path / "mine.py"


def study(file, *names, **settings):
    return Study.from_dict(
        {"name": "s", "trials": 4, "budget": 60, "problems": [{"name": "sphere-2"}],
         "optimizers": [{"name": f"{file}:{name}"} for name in names]} | settings
    )  # fmt: skip


def test_an_optimizer_that_learns_from_trial_to_trial_is_named_and_an_honest_one_is_not(file, tmp_path):
    outcome = run(study(file, "learns", "honest"), tmp_path / "out", n_jobs=1)
    [line] = outcome.different
    assert line.startswith("different: learns on sphere-2, trial ")
    assert outcome.made == len(load_results(tmp_path / "out")) == 8
    noted = Folder(tmp_path / "out").noted(VERIFICATION)["at_ends"]
    assert sorted(noted) == sorted([[1, line], [2, ""]])
    [finding] = Results(tmp_path / "out").verifications
    assert finding["at_ends"] == {
        "trials": 2,
        "sentence": "1 of 2 trials that runs made again at their ends, one of each optimizer in a fresh process, are "
        "the same bit by bit",
        "different": [line],
    }


@pytest.mark.slow
def test_a_run_that_makes_nothing_repeats_nothing_and_none_is_repeated_without_verify(file, tmp_path):
    assert run(study(file, "learns"), tmp_path / "out", n_jobs=1, verify=False).different == []
    assert Folder(tmp_path / "out").noted(VERIFICATION) == {}
    assert run(study(file, "learns"), tmp_path / "out", n_jobs=1).different == []
    assert Folder(tmp_path / "out").noted(VERIFICATION) == {}


def test_the_warm_up_does_not_evaluate_the_problem(tmp_path):
    (tmp_path / "mine.py").write_text(LEARNS)
    (tmp_path / "other.py").write_text(
        "from bench import FunctionProblem\nvalues = []\n"
        "def other():\n    return FunctionProblem(lambda x: (x**2).sum(axis=1) + 7, [-5] * 2, [5] * 2, name='other')\n"
    )
    made = study(tmp_path / "mine.py", "remembers", trials=1, problems=[{"name": f"{tmp_path / 'other.py'}:other"}])
    run(made, tmp_path / "out", n_jobs=1)
    assert load_results(tmp_path / "out")["fun"].item() > 7  # the first value that it has ever seen was a sphere's


@pytest.mark.slow
def test_a_plan_counts_the_trials_that_are_made_again(file, tmp_path, bench_here):
    text = study(file, "learns", "honest").to_toml()
    (tmp_path / "study.toml").write_text(text)
    planned = plan(study(file, "learns", "honest"), tmp_path / "out")
    assert planned.total(lambda problem, optimizer: 2.0 if optimizer == "learns" else 1.0) == 4 * 2.0 + 4 + 2.0 + 1
    said = bench_here("run", tmp_path / "study.toml", "--dry-run", "--jobs", 1).stdout
    assert "2 runs more at the end: one of each optimizer is made again and compared" in said
    assert "more at the end" not in bench_here("run", tmp_path / "study.toml", "--dry-run", "--verify", 0).stdout


def test_the_command_names_them_and_ends_with_1_and_status_repeats_them(file, tmp_path, bench_here):
    (tmp_path / "study.toml").write_text(study(file, "learns", "honest").to_toml())
    done = bench_here("run", tmp_path / "study.toml", "-o", tmp_path / "out", "--jobs", 1, "--no-report")
    assert done.returncode == 1
    assert "different: learns on sphere-2" in done.stdout
    assert "different: learns on sphere-2" in bench_here("status", tmp_path / "out").stdout


def test_a_note_by_a_stranger_raises_no_other_error(file, tmp_path):
    folder = Folder(tmp_path / "out")
    run(study(file, "honest"), folder.path, n_jobs=1, verify=False)
    for part in ("[]", '{"trials": "x"}', "[[1]]", '[["x", 3]]', "[[[1], {}]]", "[3]"):
        (folder.path / VERIFICATION).write_text(f'{{"at_ends": {part}}}')
        assert "at_ends" not in folder.verification()


def test_a_trial_that_a_limit_of_time_has_ended_is_not_made_again_and_the_plan_warns(file, tmp_path):
    timed = study(file, "honest", time=1e-6, trials=1)
    said = plan(timed, tmp_path / "out").notes
    outcome = run(timed, tmp_path / "out", n_jobs=1)
    (row,) = Folder(tmp_path / "out").store.rows()
    assert (row["status"], row["stop"], row["nfev"]) == ("ok", "time", 10)
    assert not outcome.different
    assert not Folder(tmp_path / "out").noted(VERIFICATION)
    assert any("cannot be repeated bit by bit" in note for note in said)
    with pytest.raises(
        BenchError, match="no finished trial to verify, but of those that a limit of time may have decided"
    ):
        verify(tmp_path / "out")


@pytest.mark.parametrize(
    ("row", "expected"),
    [({"status": "ok", "stop": "budget", "failures": 0}, False), ({"status": "failed"}, True),
     ({"status": "ok", "stop": "budget", "failures": 1}, True), ({"status": "ok", "stop": "time"}, True)],
)  # fmt: skip
def test_a_limit_of_an_evaluation_may_decide_a_trial_in_which_one_failed(row, expected, file):
    assert by_the_clock(row, study(file, "honest", evaluation_timeout=1)) is expected
    assert by_the_clock(row, study(file, "honest")) is (row.get("stop") == "time")


def test_the_plan_warns_of_a_limit_of_evaluations(file, tmp_path):
    said = plan(study(file, "honest", evaluation_timeout=30), tmp_path / "out").notes
    assert "a point fails after 30 s: a trial in which one did depends on the machine and is not made again" in said


READS = """
import ctypes

def reads(objective, rng):
    library = ctypes.CDLL(None)  # whose fopen nobody sees
    library.fopen.restype, library.fgetc.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    first = library.fgetc(library.fopen({path!r}.encode(), b"r"))
    while True:
        objective(objective.initial(1) * (first / 255))
"""


def test_a_cell_gets_no_more_trials_where_a_stored_one_differs_by_what_nobody_sees(tmp_path):
    data, path = tmp_path / "data.bin", tmp_path / "mine.py"
    data.write_text("a")
    path.write_text(READS.format(path=str(data)) + LEARNS)
    made = study(path, "reads", "honest", trials=2)
    assert run(made, tmp_path / "out", n_jobs=1).doubtful == []
    before = load_results(tmp_path / "out")
    data.write_text("b")
    assert run(made, tmp_path / "out", n_jobs=1).made == 0  # nothing is added, so nothing is asked
    outcome = run(made.override(trials=3), tmp_path / "out", n_jobs=1)
    [line] = outcome.doubtful
    assert line.startswith("different: reads on sphere-2, trial ")
    assert outcome.made == 1
    assert "nothing was added to 1 cell, as a stored trial of each differs" in outcome.remedy
    after = load_results(tmp_path / "out")
    assert after.groupby("optimizer").size().to_dict() == {"honest": 3, "reads": 2}
    data.write_text("a")
    assert run(made.override(trials=3), tmp_path / "out", n_jobs=1).made == 1
    assert len(before.merge(load_results(tmp_path / "out"))) == 4


def test_each_run_notes_what_it_selected(file, tmp_path):
    folder, made = Folder(tmp_path / "out"), study(file, "honest", trials=1)
    run(made, folder.path, n_jobs=1)
    run(made.override(trials=2), folder.path, n_jobs=1)
    first, second = folder.history()
    assert (first["trials"], second["trials"]) == (1, 2)
    assert (first["problems"], first["optimizers"], first["seed"]) == (["sphere-2"], ["honest"], 0)
    run(made, tmp_path / "other", n_jobs=1, reuse=[folder.path])
    reused = [record.get("reused", "") for record in Folder(tmp_path / "other").history()]
    assert sorted(reused) == ["", "out", "out"]  # by the second in which each began
