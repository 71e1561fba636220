"""Points evaluated side by side: the same results, and failures that cost one point each."""

import os
import signal
import sys
import time

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Study, run, solve
from bench.execution import side_by_side
from bench.execution.side_by_side import evaluated
from bench.execution.verify import verify
from bench.helpers.errors import PointError
from bench.storage.folder import Folder
from bench.trial.scoring import scored

X = np.array([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]])


def problem(fun=lambda x: (x**2).sum(axis=1) / 3):
    return FunctionProblem(fun, [-5.0] * 2, [5.0] * 2, vectorized=True)


def outcome(result):
    trace = result.trace
    return result.fun, result.x.tolist(), result.nfev, trace.evaluations.tolist(), trace.values.tolist()


@pytest.mark.parametrize("on_error", ["fail", "worst"])
@pytest.mark.parametrize("optimizer", ["cma-es", "gwo"])
@pytest.mark.sampled(2)
def test_a_run_is_the_same_with_any_number_of_processes(optimizer, on_error):
    found = [outcome(solve(problem(), optimizer, budget=150, seed=1, on_error=on_error, parallel=n)) for n in (1, 2, 8)]
    assert found[1:] == found[:1] * 2


def test_the_points_of_a_call_are_evaluated_at_a_time():
    met = os.pipe()

    def waits(x):  # until another process has written, which a single one would wait for without an end
        os.write(met[1], b"xx" if x[0, 0] < 1.5 else b"")
        if x[0, 0] >= 1.5:
            os.read(met[0], 1)
        return x[:, 0]

    with evaluated(problem(waits), 3) as beside:
        order = X[[1, 2, 0]]
        assert beside.evaluate(order).tolist() == [2.0, 3.0, 1.0]


def test_values_have_the_order_of_their_points():
    def slow(x):
        time.sleep(0.05 * (4 - x[0, 0]))
        return x[:, 0]

    with evaluated(problem(slow), 4) as beside:
        assert beside.evaluate(X).tolist() == [1.0, 2.0, 3.0, 4.0]


class TestFailures:
    @staticmethod
    def deed(what):
        def fun(x):
            if x[0, 0] == 2.0:
                what()
            return x[:, 0]

        return problem(fun)

    @staticmethod
    def values(failing, seconds=None, parallel=2):
        with evaluated(scored(failing, "death", "worst"), parallel, seconds) as beside:
            return beside.evaluate(X).tolist(), beside.failed

    @pytest.mark.parametrize(
        "what",
        [lambda: 1 / 0, lambda: os._exit(3), lambda: os.kill(os.getpid(), signal.SIGKILL), sys.exit],
        ids=["raises", "ends", "is killed", "exits"],
    )
    def test_a_point_that_fails_costs_no_other_one(self, what):
        assert self.values(self.deed(what)) == ([1.0, np.inf, 3.0, 4.0], 1)

    def test_a_point_that_returns_nothing_fails(self):
        nothing = problem(lambda x: None if x[0, 0] == 2.0 else x[:, 0])
        assert self.values(nothing) == ([1.0, np.inf, 3.0, 4.0], 1)

    @pytest.mark.parametrize("parallel", [1, 2])
    def test_a_point_that_hangs_fails_at_its_limit(self, parallel):
        assert self.values(self.deed(lambda: time.sleep(600)), 1.0, parallel) == ([1.0, np.inf, 3.0, 4.0], 1)

    @pytest.mark.parametrize(
        ("what", "reason"),
        [
            (lambda: 1 / 0, "ZeroDivisionError: division by zero"),
            (lambda: os._exit(3), "an evaluation ended its process with exit code 3"),
            (lambda: os.kill(os.getpid(), signal.SIGKILL), "an evaluation ended its process with signal SIGKILL"),
            (lambda: time.sleep(600), r"an evaluation took more than 1 s \(evaluation_timeout\)"),
        ],
    )
    @pytest.mark.sampled(2)
    def test_else_the_reason_is_raised(self, what, reason):
        with evaluated(self.deed(what), 2, 1.0) as beside, pytest.raises(PointError, match=reason):
            beside.evaluate(X)

    def test_no_point_is_begun_after_one_that_fails_a_trial(self, tmp_path):
        def fails(x):
            (tmp_path / f"{x[0, 0]:g}").touch()
            raise RuntimeError("no convergence")

        with evaluated(problem(fails), 1, 60.0) as beside, pytest.raises(PointError):
            beside.evaluate(X)
        assert [file.name for file in tmp_path.iterdir()] == ["1"]


def test_no_process_is_left():
    made = []
    with evaluated(problem(), 3) as beside:
        beside.evaluate(X)
        made += [process.pid for process in beside.evaluate.__self__._processes._all.values()]
    assert len(made) == 3
    for pid in made:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_processes_that_are_started_anew_give_the_same(monkeypatch):
    monkeypatch.setattr(side_by_side, "START", "spawn")
    with evaluated(problem(), 1, 60.0) as beside:
        assert beside.evaluate(X).tolist() == problem().evaluate(X).tolist()


def test_a_noisy_problem_is_refused_in_a_sentence():
    noisy = FunctionProblem(lambda x, rng: x[:, 0], [-1.0], [1.0], noiseless=lambda x: x[:, 0])
    with pytest.raises(BenchError, match="'function' is noisy, and its noise is drawn for one point after the other"):
        solve(noisy, "random-search", budget=5, parallel=2)


FAILING = """
import os, bench
def fun(x):
    if x[0] > 0.5:
        raise RuntimeError("no convergence")
    if x[0] < -0.5:
        os._exit(1)
    return float((x**2).sum())
mine = bench.FunctionProblem(fun, [-1.0] * 2, [1.0] * 2, vectorized=False, name="mine")
"""


def study(tmp_path, **changes):
    file = tmp_path / "mine.py"
    file.write_text(FAILING, encoding="utf-8")
    return Study.from_dict(
        {"name": "s", "trials": 1, "budget": 30, "problems": [{"name": f"{file}:mine", "label": "mine"}],
         "optimizers": ["random-search"], "on_error": "worst", "parallel": 8} | changes
    )  # fmt: skip


def test_a_trial_of_a_study_is_the_run_of_its_seed(tmp_path):
    run(one := study(tmp_path, evaluation_timeout="1 min"), tmp_path / "eight", n_jobs=1, verify=False)
    (row,) = Folder(tmp_path / "eight").store.rows()
    alone = solve(one.problem("mine"), "random-search", budget=30, seed=row["seed"], evaluation_timeout="1 min")
    assert (row["status"], row["trace"], row["calls"]) == ("ok", alone.trace.packed(), alone.usage.calls)


@pytest.mark.slow
def test_the_trials_of_a_study_repeat_and_are_the_same_where_problem_and_optimizer_are_kept_apart(tmp_path):
    assert not run(study(tmp_path), tmp_path / "eight", n_jobs=1).different
    assert not verify(tmp_path / "eight", trials=1).different
    assert Folder(tmp_path / "eight").verification()["at_ends"]["trials"] == 1
