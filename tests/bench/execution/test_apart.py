"""Problems kept apart: the same bits for the honest; no peeking, no overspending, and no problem to import."""

import re
import sys
from dataclasses import replace
from textwrap import dedent

import pytest

from bench import BenchError, Study, load_results, run
from bench.execution.job import Task
from bench.execution.supervisor import Supervisor
from bench.execution.verify import verify
from bench.storage.rows import disagreement
from bench.storage.store import Store

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="problems are kept apart where processes fork, as on Linux"),
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
                objective._nfev = objective._improved_at[-1]  # as few as its trace allows

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

    def forges(objective, rng):
        if hasattr(objective._problem, "variables"):
            type(objective._problem).evaluate = lambda self, x: np.zeros(len(x))
            objective._compute = objective._problem.evaluate
        objective(objective.initial(5))
        objective.stop("found")

    def knows_it(objective, rng):
        from bench.trial import trial

        trial.process_time = lambda: 1e9 * time.process_time()
        objective(np.zeros(objective.dimension))
        objective.stop("found")

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
NOISE = """
    import numpy as np
    from bench import FunctionProblem

    class Noise(FunctionProblem):
        def __init__(self):
            super().__init__(lambda x: np.random.default_rng().random(len(x)), [-1.0], [1.0])
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


def made(study, apart):
    """The rows of a study's trials, made as a verification makes them or as a run does."""
    supervisor = Supervisor(replace(Task.of(study), timeout=60, apart=apart))
    try:
        return {trial: supervisor.make(trial) for trial in study.plan()}
    finally:
        supervisor.close()


def made_apart(study):
    return made(study, apart=True)


def test_an_honest_optimizer_gives_the_same_bits(tmp_path):
    run(study(*HONEST), tmp_path / "here", n_jobs=2)
    here, apart = Store(tmp_path / "here"), made_apart(study(*HONEST))
    assert len(apart) == 12
    assert [row["status"] for row in apart.values()] == ["ok"] * 12
    assert [trial for trial, row in apart.items() if disagreement(here.find(*trial.key), row | trial.columns)] == []


def test_who_peeks_overspends_forges_or_imports_is_named_by_a_verification(cheats, tmp_path):
    ways = "attribute", "method", "collector", "frames"
    cheating = [{"name": f"{cheats}:peeks", "label": way, "way": way} for way in ways]
    cheating += [{"name": f"{cheats}:{name}"} for name in ("overspends", "forges", "imports")]
    run(study(*cheating, {"name": "hill-climber"}), tmp_path / "out", n_jobs=2)
    frame = load_results(tmp_path / "out")
    assert frame["status"].eq("ok").all(), list(
        frame["error"].dropna()
    )  # what is stored by default is not proof against them
    found = verify(tmp_path / "out", trials=2)
    assert {trial.optimizer for trial in found.different} == {*ways, "overspends", "forges", "imports"}
    hidden = [said for trial, said in found.different.items() if trial.optimizer == "imports"]
    assert all("hidden from optimizers here" in said for said in hidden)


def test_who_learns_from_a_file_is_named_by_its_file_or_by_its_trials(cheats, tmp_path):
    run(study({"name": f"{cheats}:learns"}), tmp_path / "out", n_jobs=1)
    try:
        named = {trial.optimizer for trial in verify(tmp_path / "out", trials=2).different}
    except BenchError as error:  # where a process read the file before another trial wrote it
        named = set(re.findall(r"(learns) changed \(.*\.npy", str(error)))
    assert named == {"learns"}


BLAME = """
    import numpy as np

    from bench import FunctionProblem
    from bench.helpers.errors import ProblemError

    def crash(x):
        raise RuntimeError("no mass")

    crashing = FunctionProblem(crash, [-1.0, -1.0], [1.0, 1.0], name="crashing", vectorized=True)

    def accuses(objective, rng):
        raise ProblemError(RuntimeError("not me"))

    def swallows(objective, rng):
        while True:
            try:
                objective(objective.initial(1))
            except Exception:
                return
"""


def test_a_problem_that_raises_in_its_own_process_is_blamed_whatever_the_optimizer_makes_of_it(tmp_path):
    (tmp_path / "blame.py").write_text(dedent(BLAME))
    plug_in = f"{tmp_path / 'blame.py'}:"
    accused = Study.from_dict(
        {"name": "s", "trials": 1, "budget": 20, "problems": [{"name": f"{plug_in}crashing"}, {"name": "sphere-3"}],
         "optimizers": [{"name": "hill-climber"}, {"name": f"{plug_in}swallows"}, {"name": f"{plug_in}accuses"}]}
    )  # fmt: skip
    errors = {(trial.problem, trial.optimizer): row.get("error") for trial, row in made_apart(accused).items()}
    for optimizer in ("hill-climber", "swallows"):
        assert errors["crashing", optimizer].startswith("ProblemError: RuntimeError: no mass"), optimizer
    assert "ProblemError" not in errors["sphere-3", "accuses"].partition("\n")[0]
    assert "not me" in errors["sphere-3", "accuses"]
    assert errors["sphere-3", "hill-climber"] is None


def test_the_budget_is_kept_where_the_optimizer_cannot_reach(cheats):
    rows = made_apart(study({"name": f"{cheats}:swallows"}, {"name": f"{cheats}:overspends"})).values()
    assert [(row["status"], row["nfev"], row["stop"]) for row in rows] == [("ok", 200, "budget")] * 8


def one(optimizer, apart=True):
    """The row of the only trial of an optimizer."""
    head = {"name": "s", "trials": 1, "budget": 200, "problems": [{"name": "sphere-2"}]}
    (row,) = made(Study.from_dict(head | {"optimizers": [{"name": optimizer}]}), apart).values()
    return row


@pytest.mark.parametrize("apart", [False, True])
def test_an_optimum_known_by_heart_and_invented_processor_time_are_not_noticed(cheats, apart):
    row = one(f"{cheats}:knows_it", apart)
    assert (row["status"], row["fun"], row["nfev"]) == ("ok", 0.0, 1)
    assert row["cpu_s"] > 3600


def test_the_process_that_keeps_the_problem_is_not_asked_for_too_much(cheats):
    row = one(f"{cheats}:asks_for_too_much")
    assert row["status"] == "failed"
    assert "a problem in another process takes 4,194,304 points at a time, not 5,000,000" in row["error"]


def test_the_clock_begins_once_and_a_declared_reason_arrives(cheats):
    row = one(f"{cheats}:asks_for_nothing")
    assert (row["status"], row["stop"], row["nfev"]) == ("ok", "rest", 5)
    assert row["wall_s"] >= 0.2


def test_noise_that_a_problem_does_not_declare_is_named(cheats, tmp_path):
    (tmp_path / "noise.py").write_text(dedent(NOISE))
    problem = {"name": f"{tmp_path}/noise.py:Noise"}
    given = {"name": "s", "trials": 1, "budget": 50, "problems": [problem], "optimizers": [{"name": "hill-climber"}]}
    (row,) = made_apart(Study.from_dict(given)).values()
    assert "has noise that it does not declare" in row["error"]
