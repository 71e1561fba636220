"""The evaluator of optimizers that a language model, or a search over programs, writes."""

from __future__ import annotations

import ast
import json
import warnings
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from threading import Lock
from typing import Any
from weakref import finalize

import numpy as np
import pandas as pd

from bench.analysis.comparison import compare
from bench.analysis.target_sets import area_over_curve
from bench.contract.numbers import require_positive, require_whole, seconds
from bench.contract.objective import Trace
from bench.contract.seeds import trial_seed
from bench.evaluator import found as words
from bench.evaluator.found import LEAST, Final, Found
from bench.evaluator.workers import WARMING, Candidate, Workers
from bench.execution.job import Task
from bench.execution.warming import warm_problem
from bench.helpers.errors import BenchError, explained
from bench.helpers.text import listing
from bench.plugins import objects
from bench.plugins.from_file import SOURCE, located
from bench.plugins.loading import OBJECT, OptimizerLike, ProblemLike, is_plugin
from bench.study import Study
from bench.trial.columns import Row
from bench.trial.trial import Trial

BASELINES = ("cma-es", "random-search")
LABEL = "candidate"
LONGEST = 1_000_000  # characters of a source
PARSED = 50_000  # those of a source that is worth parsing here, before any process is started for it
_NAME = f"{OBJECT}{LABEL}"
_KEY = f"optimizers {_NAME}"
_COLUMNS = [
    "problem", "optimizer", "trial", "seed", "status", "error", "fun", "nfev", "stop", "wall_s", "cpu_s", "aocc",
]  # fmt: skip

Source = OptimizerLike | PathLike[str]
"""A candidate: Python source, a path to a file of it, or an optimizer, a class or a function."""


class Evaluator:
    """Judges optimizers by the same trials on the same problems, in a sandbox and side by side.

    Every candidate has the same seeds. Its trials count in the processes of the problems, which it cannot reach. The
    processes start with the first candidate and stay, so close it, or use it in a ``with`` block. Threads may share it.

    Example:
        >>> judge = bench.Evaluator(train="bbob-f*-d5-i1", test="bbob-f*-d5-i[6-8]")
        >>> judge(source).score

    Args:
        train: the problems of the score: a name or a pattern, a problem, or several of these.
        test: the held-out problems of :meth:`final`, likewise.
        budget: evaluations of a trial, or a multiple of the dimension.
        trials: of a candidate on each problem of ``train``.
        timeout: wall seconds that a trial may take, with the loading of the candidate.
        memory: GB that a trial may use.
        n_jobs: trials made at a time; -1 takes every core.
        seed: from which the seeds of all trials derive.
        sandbox: whether candidates run in a sandbox of bubblewrap. False has them run in processes of their own, with
            the limits, but with your files, your network and your environment's variables at hand.
        baselines: optimizers that candidates are compared with; each is run once.

    Raises:
        BenchError: without bubblewrap, for problems of ``train`` among those of ``test``, and for what no study takes.
    """

    def __init__(
        self,
        train: ProblemLike | Iterable[ProblemLike],
        test: ProblemLike | Iterable[ProblemLike] = (),
        *,
        budget: int | str = "2000 * d",
        trials: int = 2,
        timeout: float | str = 10.0,
        memory: float = 2.0,
        n_jobs: int = -1,
        seed: int = 0,
        sandbox: bool = True,
        baselines: Sequence[str] = BASELINES,
    ) -> None:
        require_whole("n_jobs", n_jobs, -1)
        require_positive("the memory of a trial", memory, unit="gigabytes")
        optimizers = [{"name": _NAME, "label": LABEL}, *dict.fromkeys((*baselines, WARMING))]
        common = {"name": "evaluator", "trials": trials, "budget": budget, "seed": seed, "optimizers": optimizers}
        parts = [
            Study.from_dict(common | {"problems": chosen}, "of the evaluator").problems if chosen else ()
            for chosen in map(_listed, (train, test))
        ]
        self._train, self._test = ([entry.label for entry in part] for part in parts)
        seen = {(entry.name, repr(entry.options)) for entry in parts[0]}
        if twice := [entry.label for entry in parts[1] if (entry.name, repr(entry.options)) in seen]:
            raise BenchError(f"problems of train cannot be held out for the final: {listing(twice, 5)}")
        self._study = Study.from_dict(common | {"problems": [*_listed(train), *_listed(test)]}, "of the evaluator")
        self._optima, self._budgets = dict[str, float](), dict[str, int]()
        self._load()
        self._assumed = [label for label in [*self._train, *self._test] if label not in self._optima]
        limits: dict[str, Any] = {"timeout": seconds(timeout, "timeout"), "memory": round(memory * 1e9)}
        held = objects.among([], [entry.name for part in parts for entry in part])
        task = Task(self._study, **limits, apart=True, untrusted=sandbox, objects=held)
        try:
            self._workers = Workers(task, n_jobs)
        except BenchError as error:
            reason = str(error).removeprefix("--untrusted needs ").removeprefix("--untrusted ")
            raise BenchError(
                f"candidates are run in a sandbox: {reason}; or say sandbox=False to run them without one"
            ) from error
        self._baselines = [*dict.fromkeys(baselines)]
        self._known = dict[str, pd.DataFrame]()  # trials of the baselines, by the problems
        self._judged: list[dict[str, Any]] = []
        self._finals, self._lock = 0, Lock()
        self._end = finalize(self, self._workers.close)

    def __enter__(self) -> Evaluator:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        """Refuse to be sent to another process."""
        raise BenchError(
            "an Evaluator cannot be sent to other processes, as it has processes of its own; call it from threads, as "
            "by parallel_backend='threading'"
        )

    def close(self) -> None:
        """End all processes."""
        self._end()

    def __call__(self, source: Source) -> Found:
        """Return what the training problems show of a candidate."""
        return self.map([source])[0]

    def map(self, sources: Iterable[Source]) -> list[Found]:
        """Judge candidates side by side; return what is found of each, in their order."""
        candidates, each = [_read(source) for source in sources], len(self._train) * self._study.trials
        trials = self._trials(LABEL, self._train, self._study.trials)
        tasks = [(candidate, trial) for candidate in candidates for trial in trials]
        baselines = self._of_baselines("train", self._train, self._study.trials)
        rows = [*self._workers.rows(tasks)]
        frames = [self._frame(trials, rows[i : i + each]) for i in range(0, len(tasks), each)]
        return [self._found(*made, baselines) for made in zip(candidates, frames, strict=True)]

    def final(self, source: Source, *, trials: int = 10) -> Final:
        """Compare a candidate with the baselines on the held-out problems, whose first use alone is a test.

        Raises:
            BenchError: without held-out problems.
        """
        if not self._test:
            raise BenchError("there are no held-out problems: give some as 'test'")
        require_whole("trials", trials, 2)
        candidate, made = _read(source), self._trials(LABEL, self._test, trials)
        baselines = self._of_baselines(f"test {trials}", self._test, trials)
        rows = self._workers.rows((candidate, trial) for trial in made)
        frame = pd.concat([self._frame(made, rows), baselines], ignore_index=True)
        with self._lock:
            self._finals += 1
            finals, judged = self._finals - 1, len({each["hash"] for each in self._judged})
        return Final(compare(frame, LABEL, before=True), frame, judged, finals, candidate.reason)

    def log(self, path: str | PathLike[str]) -> None:
        """Write a JSON line for each candidate judged so far: hash of its source, score, error bar and error."""
        with explained(f"{path} cannot be written"):
            Path(path).write_text("".join(f"{json.dumps(each)}\n" for each in self._judged), encoding="utf-8")

    def llamea(self, solution: Any, logger: Any = None) -> Any:  # noqa: ARG002 - LLaMEA gives one
        """Judge a solution of LLaMEA or BLADE and return it with its scores: ``LLaMEA(judge.llamea, …)``.

        LLaMEA needs ``parallel_backend="threading"`` for it.
        """
        found = self(solution.code)
        solution.set_scores(found.score, found.feedback, RuntimeError(found.error) if found.error else None)
        return solution

    def evaluate(self, path: str | PathLike[str]) -> dict[str, Any]:
        """Judge the program of a file, as the ``evaluate`` of OpenEvolve does."""
        found = self(Path(path))
        bar = 0.0 if np.isnan(found.error_bar) else found.error_bar
        texts = {"feedback": found.feedback, "error": found.error}
        return {"combined_score": found.score, "error_bar": bar, "artifacts": {k: v for k, v in texts.items() if v}}

    def _load(self) -> None:
        """Load the problems, which are trusted; what they compile is kept in files, which no sandbox can write."""
        for label in (*self._train, *self._test):
            problem = self._study.problem(label)
            self._budgets[label] = self._study.evaluations(problem.dimension)
            warm_problem(problem, self._budgets[label])
            if problem.optimum is not None:
                self._optima[label] = problem.optimum

    def _trials(self, optimizer: str, problems: Sequence[str], trials: int) -> list[Trial]:
        """Return the trials of an optimizer, all problems first."""
        seed = self._study.seed
        return [
            Trial(problem, optimizer, number, trial_seed(seed, problem, optimizer, number))
            for number in range(trials)
            for problem in problems
        ]

    def _of_baselines(self, key: str, problems: Sequence[str], number: int) -> pd.DataFrame:
        """Return the trials of the baselines on these problems, which are made once, and set the optima."""
        if not self._end.alive:
            raise BenchError("the evaluator is closed: make another one")
        with self._lock:
            if key not in self._known:
                trials = [each for label in self._baselines for each in self._trials(label, problems, number)]
                installed = Candidate({})
                rows = [*self._workers.rows((installed, trial) for trial in trials)]
                if installed.error:
                    raise BenchError(f"a baseline failed: {installed.error}")
                for label in set(problems) & {*self._assumed}:
                    values = [row["fun"] for trial, row in zip(trials, rows, strict=True) if trial.problem == label]
                    if not values:
                        raise BenchError(f"the optimum of {label} is unknown, and no baseline stands for it")
                    self._optima.setdefault(label, min(values))
                self._known[key] = self._frame(trials, rows)
            return self._known[key]

    def _frame(self, trials: Sequence[Trial], rows: Iterable[Row]) -> pd.DataFrame:
        """Return trials as a tidy frame with the AOCC of each."""
        made = []
        for trial, row in zip(trials, rows, strict=True):
            area = 0.0
            if row["status"] == "ok":
                optimum, budget = self._optima[trial.problem], self._budgets[trial.problem]
                area = area_over_curve(Trace.unpacked(row["trace"]), optimum, budget)[0]
            made.append({"error": "", **trial.columns, **row, "aocc": area})
        return pd.DataFrame(made).reindex(columns=_COLUMNS)

    def _found(self, candidate: Candidate, frame: pd.DataFrame, baselines: pd.DataFrame) -> Found:
        """Return what the trials of a candidate show, and keep it in the record."""
        every = pd.concat([frame, baselines], ignore_index=True)
        by_problem = every.pivot_table("aocc", "problem", "optimizer", sort=False)
        score, bar, notes = 0.0, 0.0, tuple[str, ...]()
        feedback = words.shortened(f"Score 0, as it failed: {candidate.reason}")
        if not candidate.error:
            score = max(float(frame["aocc"].mean()), LEAST)
            groups = frame.groupby("problem", sort=False)["aocc"]
            bar = float(np.sqrt((groups.var() / groups.size()).sum(skipna=False)) / groups.ngroups)
            used = frame["nfev"] / frame["problem"].map(self._budgets)
            feedback = words.feedback(score, bar, by_problem, float(used.mean()))
            notes = words.notes(frame, self._optima, self._assumed)
        kept = {"hash": candidate.held[_KEY].digest, "score": score, "error_bar": None if np.isnan(bar) else bar}
        with self._lock:
            self._judged.append(kept | {"error": candidate.reason})
        return Found(score, bar, candidate.reason, feedback, frame, by_problem, notes)


def _listed(problems: ProblemLike | Iterable[ProblemLike]) -> list[Any]:
    return [problems] if isinstance(problems, str) or is_plugin(problems) else [*problems]  # type: ignore[misc]


def _read(source: Source) -> Candidate:
    """Return a candidate as its processes take it; it is not run here."""
    if isinstance(source, PathLike) or (isinstance(source, str) and "\n" not in source and source.endswith(".py")):
        with explained(f"the candidate {source} cannot be read", (OSError, ValueError)):
            source = Path(source).read_text(encoding="utf-8")
    text = source if isinstance(source, str) else ""
    if len(text) > LONGEST:
        raise BenchError(f"a candidate may have {LONGEST:,} characters, not {len(text):,}")
    candidate = Candidate({_KEY: objects.packed(source)}, text)
    if len(text) <= PARSED:
        try:
            with warnings.catch_warnings(action="ignore"):
                ast.parse(text, SOURCE)
        except SyntaxError as error:
            candidate.error = located(error)
        except (ValueError, RecursionError, MemoryError):  # of a NUL byte, or of what is nested too deeply
            pass
    return candidate
