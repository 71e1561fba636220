"""The command reproduce: reading alone, its exit codes, and one sentence for each thing that cannot be judged."""

import shutil

import pandas as pd
import pytest

from tests.bench.reproduce.test_protocol import results  # noqa: F401 - a fixture

HEAD = "# suite = 'classical'\n# dimension = 2\n# budget = 200\n# runs = 6\n# values = 'error'\n"


@pytest.fixture
def called(bench_here, tmp_path):
    """Return a function that writes a table, calls the command on it, and returns exit code and output."""

    def call(text, *arguments):
        (tmp_path / "paper.csv").write_text(text, encoding="utf-8")
        done = bench_here("reproduce", "paper.csv", *arguments, cwd=tmp_path)
        return done.returncode, done.stdout + done.stderr

    return call


def test_reading_names_each_cell_that_contradicts_itself_and_ends_with_1(called):
    text = f"{HEAD}function,optimizer,mean,sd,best\nsphere,GWO,2.0,9.0,0.5\nsphere,PSO,3.0,1.0,4.0\nsphere,DE,text,1,\n"
    code, printed = called(text, "--read-only")
    assert code == 1
    assert "note: sphere, d = 2, DE (line 9): 'text' as mean is no number" in printed
    assert "sphere, d = 2, GWO (line 7): an SD of 9.0 with the mean 2.0 and the best 0.5 needs more than" in printed
    assert "its best 4.0 is above its mean 3.0" in printed
    assert printed.endswith("2 of 3 cells contradict themselves, each other or the problem\n")


@pytest.mark.slow
def test_the_protocol_is_run_and_each_cell_judged(called, tmp_path):
    rows = "sphere,Mine,1.00E9,1\nsphere,GWO,0.5,0.5\nsphere,Unheard,1,1\nackley,GWO,1,see text\n"
    code, printed = called(
        f"{HEAD}function,optimizer,mean,sd\n{rows}",
        "--jobs",
        "1",
        "--trials",
        "12",
        "--optimizer",
        "Mine=random-search",
    )
    assert code == 1
    assert "study paper: 2 problems x 2 optimizers x 12 trials" in printed
    assert "not judged: sphere, d = 2, Unheard (line 9): no optimizer is called 'Unheard'" in printed
    assert "sphere, d = 2 (Mine" in printed
    written = pd.read_csv(tmp_path / "results" / "runs" / "paper" / "reproduction.csv")
    assert written["verdict"].tolist()[:1] + written["verdict"].tolist()[2:3] == ["differs", "not judged"]
    again, once_more = called(f"{HEAD}function,optimizer,mean,sd\n{rows}", "--beside", "results/runs/paper")
    assert again == 1
    assert once_more.endswith(printed[printed.index("cell ") :])
    assert "study paper" not in once_more


def test_the_trials_of_a_folder_are_judged_beside_the_table(called, results, tmp_path):  # noqa: F811
    folder = shutil.copytree(results.paths[0], tmp_path / "run")
    text = f"{HEAD.replace('200', '40')}function,optimizer,mean,sd\nsphere,random-search,1E9,1\nackley,Unheard,1,1\n"
    code, printed = called(text, "--beside", "run")
    assert code == 0
    assert "not judged: ackley, d = 2, Unheard (line 8): no optimizer is called 'Unheard'" in printed
    assert "1 is open: no test shows a difference, and the interval is wider\n" in printed
    written = pd.read_csv(folder / "reproduction.csv")
    assert written["verdict"].tolist() == ["open", "not judged"]
    assert (folder / "published.csv").read_text(encoding="utf-8") == text
