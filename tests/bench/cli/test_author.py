"""Two days of an author: rivals are run once, the own optimizer is changed many times, a reviewer asks for less."""

import json
import re

import pytest

from bench import Results, load_results

STUDY = """
name = "mine"
trials = {trials}
budget = 40
problems = ["sphere-2", "sphere-3"]
optimizers = [{optimizers}]
"""

OWN = '''
from dataclasses import dataclass

from bench import Optimizer
from {helper} import STEP


@dataclass(frozen=True)
class Hops(Optimizer):
    """Random hops."""

    def minimize(self, objective, rng):
        x = objective.initial(1)
        while True:
            objective(objective.repair(x + STEP * rng.standard_normal(x.shape)))
'''


@pytest.fixture
def author(tmp_path, bench_here):
    """Write the files of an author, and return what runs a command in their folder and returns what it printed."""
    helper = f"step_of_{abs(hash(str(tmp_path)))}"  # each test imports its own

    def write(step=0.5, optimizers='"scatter", "hops.py:Hops"', trials=2, comment=""):
        (tmp_path / f"{helper}.py").write_text(f"STEP = {step}\n")
        (tmp_path / "hops.py").write_text(f"# {comment}\n{OWN.format(helper=helper)}")
        (tmp_path / "study.toml").write_text(STUDY.format(optimizers=optimizers, trials=trials))

    def run(*words, code=0):
        done = bench_here(*words, cwd=tmp_path)
        assert done.returncode == code, done.stdout + done.stderr
        return " ".join(f"{done.stdout} {done.stderr}".split())

    run.write, run.path, run.helper = write, tmp_path, f"{helper}.py"
    write()
    return run


RUN = "run", "study.toml", "-o", "out", "--no-report", "--jobs", "1", "--verify", "0"


def values(author):
    """Return the stored values of each optimizer that the study selects."""
    frame = load_results(author.path / "out")
    return {label: group["fun"].tolist() for label, group in frame.groupby("optimizer")}


@pytest.mark.slow
def test_two_days_beside_finished_rivals(author):
    author(*RUN)
    first = values(author)

    author.write(comment="the same")
    assert "8 of them already done" in author(*RUN)  # a comment changes nothing
    assert values(author) == first

    author.write(step=0.25)
    assert f"Hops changed since its trials were made ({author.helper})" in author("status", "out")
    assert (
        f"Hops changed ({author.helper}) and is version 2 now: 4 trials to make; the 4 of version 1 are kept"
        in author(*RUN)
    )
    second = values(author)
    assert second["scatter"] == first["scatter"]
    assert second["Hops"] != first["Hops"]
    assert "Hops: version 2 of 2 is selected; also kept: 4 trials (version 1)" in author("status", "out")

    page = author("report", "out", "--versions", "Hops", "-o", "versions")
    assert "Hops@1" in page
    assert "Hops@2" in page
    assert "undecided" in author("gate", "out", "--optimizer", "Hops", "--allow-undecided")
    author("report", "out")
    answer = json.loads((author.path / "out" / "answer.json").read_text())
    assert answer["selection"] == "Hops is version 2 of 2 run here; the others are not shown."

    author.write(step=0.5)
    assert "8 of them already done" in author(*RUN)  # back at the version before
    assert values(author) == first

    author.write(optimizers='"scatter", {name = "hops.py:Hops", label = "rHops"}')
    assert "the optimizer Hops is called rHops now, and keeps its 4 trials" in author(*RUN)
    assert values(author)["rHops"] == first["Hops"]
    author.write(optimizers='"scatter", {name = "hops.py:Hops", label = "rHops"}', trials=3)
    author(*RUN)
    extended = values(author)
    assert [value for place, value in enumerate(extended["rHops"]) if place % 3 < 2] == first["Hops"]

    author.write(optimizers='{name = "hops.py:Hops", label = "rHops"}', trials=3)
    assert "the optimizer scatter is no longer in the study: its 6 trials are kept" in author(*RUN)
    assert set(values(author)) == {"rHops"}
    author.write(optimizers='{name = "hops.py:Hops", label = "rHops"}, "scatter", "early"', trials=3)
    assert "12 of them already done" in author(*RUN)
    assert set(values(author)) == {"rHops", "scatter", "early"}

    assert "no optimizer 'gwo'" in author("rm", "out", "--optimizer", "gwo", code=2)
    said = author("run", "study.toml", "-o", "out", "--no-report", "--trials", "1", "--dry-run")
    assert "out was asked for 3 trials before, so 3 and not 1 are made of each cell" in said
    author.write(step=0.75, optimizers='{name = "hops.py:Hops", label = "rHops"}, "scatter", "early"', trials=3)
    assert re.search(r"rHops changed \(step.*\)", author("verify", "out", code=2))
    assert "4 trials would be removed" in author("rm", "out", "--old", "--dry-run")
    author("rm", "out", "--old")
    assert Results(author.path / "out").versions == {"rHops": (1, 2)}  # numbers go on meaning the same
    author("report", "out", "--optimizer", "rHops", "--dimension", "3", "-o", "asked")


@pytest.mark.slow
def test_rivals_of_another_folder_are_taken_and_not_made_again(author):
    author.write(optimizers='"scatter", "early"')
    author("run", "study.toml", "-o", "rivals", "--no-report", "--jobs", "1", "--verify", "0")
    author.write()
    said = author(*RUN, "--reuse", "rivals", "--dry-run")
    assert "scatter: 0 to run" in said
    assert "Hops: 4 to run" in said
    said = author(*RUN, "--reuse", "rivals")
    assert "2 of the study's 4 cells are in rivals; of the others no trial of Hops is there (2 cells)" in said
    assert "4 of them already done" in said
    author("pack", "rivals", "-o", "rivals.zip")
    said = author("run", "study.toml", "-o", "other", "--no-report", "--jobs", "1", "--reuse", "rivals.zip")
    assert "4 of them already done" in said
    rivals = load_results(author.path / "rivals").set_index(["problem", "optimizer", "trial"])["fun"]
    taken = load_results(author.path / "other").set_index(["problem", "optimizer", "trial"])["fun"]
    assert (taken.xs("scatter", level=1) == rivals.xs("scatter", level=1)).all()
    records = json.loads((author.path / "out" / "environment.json").read_text())
    assert [record.get("reused") for record in records] == ["rivals", None]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (["--seed", "4"], "seed 0, not 4 (2 cells)"),
        (["--budget", "50"], "evaluations 40, not 50 (2 cells)"),
    ],
)
def test_a_folder_that_has_no_equal_cell_is_refused_with_the_reason(author, changes, why):
    author.write(optimizers='"scatter"')
    author("run", "study.toml", "-o", "rivals", "--no-report", "--jobs", "1", "--verify", "0")
    said = author(*RUN, *changes, "--reuse", "rivals", code=2)
    assert f"0 of the study's 2 cells are in rivals; of the others {why}" in said
    assert not (author.path / "out").exists()
