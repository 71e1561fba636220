"""Strict trials: the same bits for the honest; no peeking, no overspending, and no problem to import."""

import sys
from textwrap import dedent

import pytest

from bench import Study, load_results, run
from bench.execution.verify import verify
from bench.storage.rows import REPEATABLE
from bench.storage.store import Store

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="strict trials need processes that fork, as on Linux"),
]

CHEATS = """
    import gc, itertools, sys, time
    from pathlib import Path

    import numpy as np

    from bench import Problem

    def found(objective, way):
        if way == "attribute":
            return getattr(objective, "_problem", None)
        if way == "method":
            return getattr(objective.repair.__self__, "_problem", None)
        if way == "collector":
            gc.unfreeze()
            return next((each for each in gc.get_objects() if isinstance(each, Problem)), None)
        frame = sys._getframe()
        while frame and "problem" not in frame.f_locals:
            frame = frame.f_back
        return frame and frame.f_locals["problem"]

    def overspends(objective, rng):
        for call in itertools.count():
            objective(objective.initial(5))
            if getattr(objective, "_improved_at", None) and call < 30:
                objective._evaluations = objective._improved_at[-1]  # as few as its trace allows

    def peeks(objective, rng, way="attribute"):
        points, problem = objective.initial(5), found(objective, way)
        if hasattr(problem, "evaluate") and problem.dimension == objective.dimension:
            many = objective.initial(500)
            points[0] = many[problem.evaluate(many).argmin()]
        while True:
            objective(points)
            points = objective.initial(5)

    def learns(objective, rng):
        notes, best = Path(__file__).with_suffix(f".{objective.dimension}.npy"), np.inf
        points = objective.initial(5)
        if notes.exists():
            points[0] = np.load(notes)
        while True:
            values = objective(points)
            if values.min() < best:
                best = values.min()
                np.save(notes, points[values.argmin()])
            points = objective.initial(5)

    def imports(objective, rng):
        from bench import load_problem

        problem = load_problem("signature-12")
        while True:
            objective(objective.initial(5))

    def asks_for_nothing(objective, rng):
        objective(objective.initial(5))
        time.sleep(0.2)
        objective._problem.evaluate(np.empty((0, 2)))  # as the first request, which starts the clock
        objective.stop("rest")

    def asks_for_too_much(objective, rng):
        objective.repair(np.zeros((5_000_000, 2)))

    def swallows(objective, rng):
        for _ in range(8):
            try:
                while True:
                    objective(objective.initial(7))
            except BaseException:
                pass
"""
HONEST = [{"name": "gwo", "agents": 10}, {"name": "hill-climber"}, {"name": "scipy:differential_evolution"}]


@pytest.fixture(scope="module")
def cheats(tmp_path_factory):
    path = tmp_path_factory.mktemp("cheats") / "cheats.py"
    path.write_text(dedent(CHEATS))
    return path


def study(*optimizers):
    return Study.from_dict(
        {"name": "s", "trials": 2, "budget": 200, "problems": [{"names": ["signature-12", "sphere-3"]}],
         "optimizers": list(optimizers)}
    )  # fmt: skip


def test_an_honest_optimizer_gives_the_same_bits(tmp_path):
    stored = []
    for strict in (False, True):
        run(study(*HONEST), tmp_path / str(strict), n_jobs=2, strict=strict)
        found = sorted(Store(tmp_path / str(strict)).rows(), key=lambda row: row["seed"])
        stored.append([{name: row[name] for name in ("problem", "optimizer", *REPEATABLE)} for row in found])
    assert stored[0] == stored[1]
    assert {row["status"] for row in stored[0]} == {"ok"}
    assert len(stored[0]) == 12


def test_who_peeks_overspends_or_learns_is_named_by_a_verification(cheats, tmp_path):
    ways = "attribute", "method", "collector", "frames"
    cheating = [{"name": f"{cheats}:peeks", "label": way, "way": way} for way in ways]
    cheating += [{"name": f"{cheats}:{name}"} for name in ("overspends", "learns")]
    run(study(*cheating, {"name": "hill-climber"}), tmp_path / "out", n_jobs=2)
    frame = load_results(tmp_path / "out")
    assert frame["status"].eq("ok").all()  # what is stored by default is not proof against them
    found = verify(tmp_path / "out", trials=2, strict=True)
    assert {trial.optimizer for trial in found.different} == {*ways, "overspends", "learns"}
    assert {trial.optimizer for trial in verify(tmp_path / "out", trials=2).different} == {"learns"}


def test_installed_problems_are_hidden(cheats, tmp_path):
    run(study({"name": f"{cheats}:imports"}), tmp_path / "out", n_jobs=1, strict=True)
    frame = load_results(tmp_path / "out")
    assert frame["status"].eq("failed").all()
    assert frame["error"].str.contains("hidden from the optimizers of strict trials").all(), list(frame["error"])


def test_the_budget_is_kept_where_the_optimizer_cannot_reach(cheats, tmp_path):
    run(
        study({"name": f"{cheats}:swallows"}, {"name": f"{cheats}:overspends"}), tmp_path / "out", n_jobs=1, strict=True
    )
    frame = load_results(tmp_path / "out")
    assert frame["status"].eq("ok").all(), list(frame["error"])
    assert frame["nfev"].eq(200).all()
    assert frame["stop"].eq("budget").all()


def test_the_process_that_keeps_the_problem_is_not_asked_for_too_much(cheats, tmp_path):
    one = {"name": "s", "trials": 1, "budget": 200, "problems": [{"name": "sphere-2"}]}
    made = Study.from_dict(one | {"optimizers": [{"name": f"{cheats}:asks_for_too_much"}]})
    run(made, tmp_path / "out", n_jobs=1, strict=True, timeout=60)
    (row,) = load_results(tmp_path / "out").to_dict("records")
    assert row["status"] == "failed"
    assert "a strict trial takes 4,194,304 points at a time, not 5,000,000" in row["error"]


def test_the_clock_begins_once_and_a_declared_reason_arrives(cheats, tmp_path):
    one = {"name": "s", "trials": 1, "budget": 200, "problems": [{"name": "sphere-2"}]}
    made = Study.from_dict(one | {"optimizers": [{"name": f"{cheats}:asks_for_nothing"}]})
    run(made, tmp_path / "out", n_jobs=1, strict=True, timeout=60)
    (row,) = load_results(tmp_path / "out").to_dict("records")
    assert (row["status"], row["stop"], row["nfev"]) == ("ok", "rest", 5)
    assert row["wall_s"] >= 0.2
