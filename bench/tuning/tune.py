"""Tune optimizers by optuna: the same number of configurations each, the defaults first, on training problems alone.

Every configuration runs on the training problems in one order, with the same seeds, and is stopped as soon as it is
worse than the best one so far by Wilcoxon's signed-rank test over the problems that it has run on. A new sampler is
seeded for each configuration from its number, so a tuning that was killed goes on to the same end as one that was not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from filelock import FileLock, Timeout

from bench.analysis.cells import NO_TRACE
from bench.analysis.target_sets import aocc
from bench.errors import PROBLEM_FAILED, BenchError, require
from bench.execution.safe_runs import Begin, found, safe_runs
from bench.helpers.console import OnStep, quiet
from bench.helpers.text import option
from bench.objective import Trace
from bench.optimizer import CONDITIONS
from bench.plugins import loading
from bench.problem import Problem
from bench.seeds import trial_seed
from bench.study.budget import Budget
from bench.study.tuned import Tuned
from bench.tuning.run import make_run, ready
from bench.tuning.space import Axis, space

OBJECTIVES = {"aocc": "1 - AOCC", "regret": "log10 of the median regret"}
"""What is minimised, the mean over the training problems, by its name on the command line."""

LEAST, MOST = 1e-8, 1e100  # regrets: COCO's smallest precision, and that of a failed run


@dataclass(frozen=True)
class TuningSetup:
    """The settings that all optimizers of a tuning share.

    Attributes:
        objective: what is minimised: "aocc", one less the mean area over the convergence curve (van Stein et al. 2024),
            or "regret", the logarithm of the median regret; of both, the mean over the training problems.
        trials: configurations of each optimizer.
        runs: runs of a configuration on each training problem.
        budget: evaluations of a run.
        seed: the seed of everything.
        train: the names of the training problems, in the order of the runs.
        fixed: options of all optimizers that are not tuned.
        timeout: wall seconds that a run may take; None for no limit.
    """

    objective: str
    trials: int
    runs: int
    budget: Budget
    seed: int
    train: tuple[str, ...]
    fixed: dict[str, Any]
    timeout: float | None = None


@dataclass(frozen=True)
class TuningRun:
    """One run of a configuration: its best value and its trace, or the ``error`` that it ended with."""

    fun: float = np.inf
    nfev: int = 0
    wall_s: float = 0.0
    trace: Trace = NO_TRACE
    error: str = ""


@dataclass(frozen=True)
class Best:
    """The best configuration of an optimizer: its options, none where no configuration was better than the defaults."""

    record: Tuned
    options: dict[str, Any]


def spaces(
    names: Sequence[str], fixed: Mapping[str, Any], least: int, conditions: Sequence[str] = ()
) -> dict[str, list[Axis]]:
    """Return the axes of each optimizer's search space; ``least`` is the smallest budget of a run.

    ``conditions`` are those of :data:`bench.optimizer.CONDITIONS` that are tuned, too.

    Raises:
        BenchError: for an unknown optimizer or parameter, a budget below a generation, a condition that no optimizer
            has as a parameter to tune, and what :func:`space` refuses.
    """
    if unknown := [name for name in conditions if name not in CONDITIONS]:
        raise BenchError(f"{unknown[0]!r} is no condition; the conditions are {', '.join(CONDITIONS)}")
    axes_of = {}
    for name in names:
        optimizer = loading.load_optimizer(name, **fixed)
        optimizer.check_budget(least, name)
        axes_of[name] = space(name, optimizer, fixed.keys(), least, conditions)
    for condition in conditions:
        if not any(axis.name == condition for axes in axes_of.values() for axis in axes):
            raise BenchError(f"no optimizer here has the condition {condition!r} as a parameter to tune; leave it out")
    return axes_of


def tune(
    axes: Mapping[str, list[Axis]],
    problems: Mapping[str, Problem],
    setting: TuningSetup,
    journal: Path,
    jobs: int = -1,
    on_progress: OnStep = lambda *_: None,
) -> list[Best]:
    """Tune the optimizers, one after the other; what the journal holds already is not run again.

    Args:
        axes: the space of each optimizer, of :func:`spaces`.
        problems: the training problems by name.
        setting: what is the same for all optimizers.
        journal: optuna's own storage; the same command with the same journal continues.
        jobs: runs made at a time, -1 for one a core; it decides nothing else.
        on_progress: called before each configuration.

    Raises:
        BenchError: where optuna is missing, or the journal is that of another tuning or cannot be written.
    """
    optuna = require("optuna", "optuna", "tuning needs")
    bests = []
    with _alone(journal), quiet(optuna), safe_runs(jobs, ready) as begin:
        storage = _storage(optuna, journal)
        for place, (name, own_axes) in enumerate(axes.items()):
            search = _Search(optuna, storage, name, own_axes, setting, problems, begin)
            for number in range(search.done, setting.trials):
                on_progress(
                    f"{name}: configuration {number + 1}", place * setting.trials + number, len(axes) * setting.trials
                )
                search.step(number)
            bests.append(search.best())
    return bests


class _Search:
    """The tuning of one optimizer: an optuna study, whose finished trials are the configurations so far."""

    def __init__(
        self, optuna: Any, storage: Any, name: str, axes: list[Axis], setting: TuningSetup,
        problems: Mapping[str, Problem], begin: Begin,
    ) -> None:  # fmt: skip
        self.optuna, self.name, self.axes, self.setting, self.begin = optuna, name, axes, setting, begin
        self.budgets = {label: setting.budget.evaluations(problem.dimension) for label, problem in problems.items()}
        self.optima = {
            label: float(problem.optimum) for label, problem in problems.items() if problem.optimum is not None
        }
        pruner = optuna.pruners.WilcoxonPruner()
        self.study = optuna.create_study(storage=storage, study_name=name, load_if_exists=True, pruner=pruner)
        same = {
            "objective": setting.objective, "number of runs": setting.runs, "budget": setting.budget.plain,
            "seed": setting.seed, "training set": list(setting.train),
            "fixed parameter": {key: option(value) for key, value in setting.fixed.items()},
            "space": [str(axis) for axis in axes],
        }  # fmt: skip
        noted = self.study.user_attrs.get("setting", same)
        if noted != same:
            changed = next(key for key in same if noted.get(key) != same[key])
            raise BenchError(
                f"the tuning of {name!r} was begun with another {changed}; repeat that one, or give another --output"
            )
        self.study.set_user_attr("setting", same)
        states = optuna.trial.TrialState
        for trial in self.study.get_trials(
            deepcopy=False, states=(states.WAITING, states.RUNNING)
        ):  # of a killed tuning
            if trial.state == states.WAITING:
                self.study.ask()  # it is running now, and can be ended
            self.study.tell(trial.number, state=states.FAIL)

    @property
    def finished(self) -> list[Any]:
        """The configurations that ran on all problems or were stopped, in their order."""
        states = (self.optuna.trial.TrialState.COMPLETE, self.optuna.trial.TrialState.PRUNED)
        return list(self.study.get_trials(deepcopy=False, states=states))

    @property
    def done(self) -> int:
        """The number of those configurations."""
        return len(self.finished)

    def step(self, number: int) -> None:
        """Run one more configuration, the defaults first."""
        seed = trial_seed(self.setting.seed, "tuning", self.name, number) % 2**32
        self.study.sampler = self.optuna.samplers.TPESampler(seed=seed)
        axes = self.axes
        if not number:
            axes = [axis for axis in axes if axis.default is not None]
            self.study.enqueue_trial({axis.name: axis.default for axis in axes})
        trial = self.study.ask()
        options = {axis.name: axis.suggest(trial) for axis in axes}
        runs = self._begin(options)
        try:
            self._judge(trial, runs)
        finally:
            for future in [future for of_problem in runs.values() for future in of_problem]:
                future.cancel()

    def _begin(self, options: dict[str, Any]) -> dict[str, list[Future[Any]]]:
        """Have a configuration run on all training problems, as far as it is not stopped before."""
        setting = self.setting
        configuration = {**setting.fixed, **options}
        begun: dict[str, list[Future[Any]]] = {}
        for problem, budget in self.budgets.items():
            for run in range(setting.runs):
                seed = trial_seed(setting.seed, problem, self.name, run)
                call = self.name, make_run, self.name, configuration, problem, budget, seed
                begun.setdefault(problem, []).append(self.begin(*call, seconds=setting.timeout))
        return begun

    def _judge(self, trial: Any, runs: Mapping[str, list[Future[Any]]]) -> None:
        """Wait for the runs, problem by problem, and stop or score the configuration."""
        spent, seconds, failed = 0, 0.0, 0
        scores: list[float] = []
        stopped = False
        for step, (problem, futures) in enumerate(runs.items()):
            outcomes = [_outcome(future) for future in futures]
            spent += sum(run.nfev for run in outcomes)
            seconds += sum(run.wall_s for run in outcomes)
            errors = [run.error for run in outcomes if run.error]
            failed += len(errors)
            if blamed := next((error for error in errors if PROBLEM_FAILED in error), ""):
                raise BenchError(
                    f"the training problem {problem} failed, which judges no configuration: "
                    f"{blamed.partition(PROBLEM_FAILED)[2]}; mend it, or leave it out"
                )
            if errors:
                trial.set_user_attr("error", errors[0])
            scores.append(score(outcomes, self.setting.objective, self.optima[problem], self.budgets[problem]))
            trial.report(scores[-1], step)
            if step + 1 < len(runs) and trial.should_prune():
                stopped = True
                break
        for key, value in (("evaluations", spent), ("seconds", seconds), ("failed", failed)):
            trial.set_user_attr(key, value)
        if stopped:
            self.study.tell(trial, state=self.optuna.trial.TrialState.PRUNED)
        else:
            self.study.tell(trial, float(np.mean(scores)))

    def best(self) -> Best:
        """Return the best of the first configurations, as many as the setting allows."""
        tried = self.finished[: self.setting.trials]
        whole = [trial for trial in tried if trial.state == self.optuna.trial.TrialState.COMPLETE]
        best = min(whole, key=lambda trial: trial.value)  # the first of equal ones; the defaults are never stopped
        label = loading.default_label(self.name)
        options = {} if best is tried[0] else {axis.name: best.params[axis.name] for axis in self.axes}
        record = Tuned(
            name=self.name,
            default=label,
            tuned=f"{label}-tuned" if options else label,
            parameters={axis.name: axis.as_dict() for axis in self.axes},
            values={axis.name: [trial.params.get(axis.name, option(None)) for trial in tried] for axis in self.axes},
            scores=[float(np.mean(list(trial.intermediate_values.values()))) for trial in tried],
            problems=[len(trial.intermediate_values) for trial in tried],
            failed=sum(trial.user_attrs["failed"] for trial in tried),
            evaluations=sum(trial.user_attrs["evaluations"] for trial in tried),
            seconds=round(sum(trial.user_attrs["seconds"] for trial in tried), 3),
            importance=self._importance(len(whole)),
        )
        return Best(record, options)

    def _importance(self, whole: int) -> dict[str, float]:
        """Return the share of each parameter in the variance of the scores; none of fewer than ten configurations."""
        if whole < 10 or len(self.axes) < 2:
            return {}
        evaluator = self.optuna.importance.PedAnovaImportanceEvaluator()
        shares = self.optuna.importance.get_param_importances(self.study, evaluator=evaluator)
        return {name: round(float(share), 4) for name, share in shares.items()}


def score(runs: Sequence[TuningRun], objective: str, optimum: float, budget: int) -> float:
    """Return the score of a configuration's runs on one problem; lower is better, and a failed run is the worst."""
    if objective == "regret":
        regrets = [MOST if run.error else run.fun - optimum for run in runs]
        return float(np.log10(np.clip(np.median(regrets), LEAST, MOST)))
    status = ["failed" if run.error else "ok" for run in runs]
    frame = pd.DataFrame({"problem": "p", "optimizer": "o", "trial": range(len(runs)), "status": status})
    traces = {("p", "o", number): run.trace for number, run in enumerate(runs)}
    return 1 - float(aocc(frame, traces, {"p": optimum}, budget)["aocc"].iloc[0])


def method(optuna: Any) -> str:
    """Return the sampler and the pruner of a tuning in words."""
    return f"optuna {optuna.__version__}, TPESampler and WilcoxonPruner"


def _run(record: dict[str, Any]) -> TuningRun:
    """Return the run of a record; raises ValueError, TypeError or KeyError for what is none."""
    trace = Trace(record["at"].astype(np.int64), record["values"])
    run = TuningRun(float(record["fun"]), int(record["nfev"]), float(record["wall_s"]), trace)
    return run if np.isfinite(run.fun) else replace(run, error="it found no finite value")


def _outcome(future: Future[Any]) -> TuningRun:
    """Return the result of a run, or why it failed."""
    try:
        return found(future, _run)
    except BenchError as error:
        return TuningRun(error=str(error))


def _storage(optuna: Any, journal: Path) -> Any:
    backend = optuna.storages.journal
    try:
        lock = backend.JournalFileOpenLock(str(journal))
        return optuna.storages.JournalStorage(backend.JournalFileBackend(str(journal), lock_obj=lock))
    except OSError as error:
        raise BenchError(f"the journal {journal} cannot be written: {error.strerror}") from error
    except (ValueError, KeyError) as error:
        raise BenchError(f"the journal {journal} is damaged; remove it to begin again") from error


@contextmanager
def _alone(journal: Path) -> Iterator[None]:
    """Keep other processes from continuing the same journal; the lock of a killed tuning ends with it."""
    hold = FileLock(journal.with_name(f".{journal.name}.lock"), timeout=0)
    try:
        hold.acquire()
    except Timeout as error:
        raise BenchError(
            f"another tuning is writing to {journal}; wait for its end or give another --output"
        ) from error
    except OSError as error:
        raise BenchError(f"the journal {journal} cannot be written: {error.strerror}") from error
    try:
        yield
    finally:
        hold.release()
