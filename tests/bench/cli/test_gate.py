"""The command gate: its three outcomes and exit codes, its Markdown, and what it refuses in one sentence."""

import numpy as np
import pytest

from bench import Study, Trace
from bench.cli.gate import CODES
from bench.storage.folder import Folder
from bench.study import Entry
from tests.bench.reports import ended, store


def write(place, name, problems=("sphere-2", "sphere-3"), optimizers=("mine",), *, shift=0.0, **changes):
    """Write the folder of a study whose trials end at 5 plus ``shift``, and noise that depends on their seed."""
    entries = (tuple(Entry(label, label) for label in labels) for labels in (problems, optimizers))
    study = Study(name, *entries, **{"trials": 12, "budget": 60, "seed": 1} | changes)

    def row_of(trial):
        fun = 5 + shift + np.random.default_rng(trial.seed).standard_normal()
        trace = Trace(np.array([1, 30]), np.array([fun + 1, fun]))
        return ended(fun, nfev=60, x={"x1": fun}, trace=trace)

    store(place / name, study, row_of)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, testing_plugins):
    """Return the folders of a version, the same again, a worse one, another seed, and a slightly better one."""
    place = tmp_path_factory.mktemp("gate")
    write(place, "old")
    write(place, "same")
    write(place, "worse", seed=2, shift=3.0)
    write(place, "other", seed=9, trials=4)
    several = tuple(f"p{number}" for number in range(8))
    write(place, "before", problems=several, trials=40)
    write(place, "after", problems=several, seed=5, trials=40, shift=-0.4)
    return place


def test_identical_trials_pass(bench_here, folders):
    done = bench_here("gate", "old", "same", cwd=folders)
    assert done.returncode == 0
    assert "every trial is identical" in " ".join(done.stdout.split())


def test_a_worse_version_fails_and_the_markdown_says_so(bench_here, folders, tmp_path):
    done = bench_here("gate", "old", "worse", "--markdown", tmp_path / "gate.md", cwd=folders)
    assert done.returncode == 1
    text = (tmp_path / "gate.md").read_text(encoding="utf-8")
    assert text.startswith(
        "## ❌ mine (worse) against mine (old): worse\n\nThe new version is worse by more than the m"
    )
    assert "| sphere-2 | 12 |" in text
    assert "A problem is worse where its one-sided p, by Holm’s method over the problems, is at most 0.025." in text
    assert bench_here("gate", "worse", "old", cwd=folders).returncode == 0


def test_a_pass_is_one_on_average_and_names_the_problems_that_are_open(bench_here, folders):
    done = bench_here("gate", "before", "after", cwd=folders)
    assert done.returncode == 0
    text = " ".join(done.stdout.replace("│", " ").split())
    assert "mine (after) against mine (before): better" in text
    assert "The new version is better on average: the old version ends better in 3" in text
    assert "It is not shown to be not worse on p" in text
    assert "(up to 6" in text
    assert "not shown" in text.split("95% interval")[1]
    strict = bench_here("gate", "before", "after", "--every-problem", cwd=folders)
    assert strict.returncode == CODES["undecided"]
    assert "A pass needs every problem, each tested at 0.025 without adjustment" in " ".join(strict.stdout.split())
    wide = bench_here("gate", "before", "after", "--every-problem", "--not-worse-than", "0.3", cwd=folders)
    assert wide.returncode == 0
    assert "not worse by more than the margin on any problem" in " ".join(wide.stdout.replace("│", " ").split())


def test_another_look_after_more_trials_is_said_with_the_way_out(bench_here, folders, tmp_path):
    for name, seed in (("old", 1), ("new", 2)):
        write(tmp_path, name, seed=seed)
    with Folder(tmp_path / "new").store.writer() as writer:
        writer.record("history", {"seed": 2, "trials": 4})
        writer.record("history", {"seed": 2, "trials": 12})
    said = " ".join(bench_here("gate", "old", "new", cwd=tmp_path).stdout.split())
    assert (
        "new was extended from 4 to 12 trials: after an undecided look, a false alarm has a chance above 0.05" in said
    )
    assert "was extended" not in bench_here("gate", "old", "other", cwd=folders).stdout


def test_a_look_that_was_undecided_is_said_at_the_next_one(bench_here, tmp_path):
    write(tmp_path, "old", trials=30)
    write(tmp_path, "new", seed=2, trials=4)
    first = " ".join(bench_here("gate", "old", "new", cwd=tmp_path).stdout.split())
    assert "undecided" in first
    assert "earlier look" not in first + bench_here("gate", "old", "new", cwd=tmp_path).stdout  # at the same trials
    write(tmp_path, "more", seed=2, trials=30)
    with Folder(tmp_path / "more").store.writer() as writer:  # as a run that extends the folder keeps it
        (look,) = (each for each in Folder(tmp_path / "new").looks())
        writer.record("history", {"look": look})
    said = " ".join(bench_here("gate", "old", "more", cwd=tmp_path).stdout.split())
    assert (
        "An earlier look at this comparison, at 68 of these 120 trials, was undecided: the level of 0.05 does" in said
    )
    assert "trials a problem with a new seed, which restores it" in said
    write(tmp_path, "anew", seed=3, trials=30)
    with Folder(tmp_path / "anew").store.writer() as writer:
        writer.record("history", {"look": look})
    assert "earlier look" not in bench_here("gate", "old", "anew", cwd=tmp_path).stdout
    assert Folder(tmp_path / "more").history() == []
