"""The evaluator of optimizers that a language model, or a search over programs, writes."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import replace
from itertools import islice
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
from bench.evaluator import found as words
from bench.evaluator.found import LEAST, Final, Found
from bench.evaluator.workers import KEY, LABEL, NAME, STAND_IN, Candidate, Source, Workers
from bench.execution.job import Task, sandbox_of
from bench.execution.warming import warm_problem
from bench.helpers.errors import BenchError, explained
from bench.helpers.parsing import JsonObject
from bench.helpers.text import listing
from bench.plugins import objects
from bench.plugins.loading import ProblemLike, is_plugin
from bench.study import Study
from bench.trial.columns import Row
from bench.trial.trial import Trial

BASELINES = ("cma-es", "random-search")
_COLUMNS = [
    "problem", "optimizer", "trial", "seed", "status", "error", "fun", "nfev", "stop", "wall_s", "cpu_s", "aocc",
]  # fmt: skip


class Evaluator(AbstractContextManager["Evaluator"]):
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
    ) -> None:
        require_whole("n_jobs", n_jobs, -1)
        require_positive("the memory of a trial", memory, unit="gigabytes")
        optimizers = [{"name": NAME, "label": LABEL}, *BASELINES]
        common = {"name": "evaluator", "trials": trials, "budget": budget, "seed": seed, "optimizers": optimizers}
        study = Study.from_dict(common | {"problems": _listed(train)}, "of the evaluator")
        held_out = replace(study, problems=()).beside(problems=_listed(test)).problems if test else ()
        seen = [(entry.name, entry.options) for entry in study.problems]
        if twice := [entry.label for entry in held_out if (entry.name, entry.options) in seen]:
            raise BenchError(f"problems of train cannot be held out for the final: {listing(twice, 5)}")
        self._train, self._test = ([entry.label for entry in part] for part in (study.problems, held_out))
        self._study = replace(study, problems=(*study.problems, *held_out))
        self._optima, self._budgets = dict[str, float](), dict[str, int]()
        for entry in self._study.problems:  # they are trusted, and what they compile no sandbox can write
            problem = self._study.problem(entry.label)
            self._budgets[entry.label] = self._study.budget.evaluations(problem.dimension)
            warm_problem(problem, self._budgets[entry.label])
            if problem.optimum is not None:
                self._optima[entry.label] = problem.optimum
        self._assumed = [label for label in self._budgets if label not in self._optima]
        held = objects.among([], [entry.name for entry in self._study.problems])
        task = Task(
            self._study, timeout=seconds(timeout, "timeout"), memory=round(memory * 1e9), apart=True, untrusted=sandbox,
            objects=held | Candidate.read(STAND_IN).held,
        )  # fmt: skip
        try:
            sandbox_of(task)
        except BenchError as error:
            reason = str(error).removeprefix("--untrusted needs ").removeprefix("--untrusted ")
            raise BenchError(f"candidates run in a sandbox: {reason}; or say sandbox=False to go without") from error
        self._workers, self._n_jobs = Workers(task, n_jobs), n_jobs
        self._known = dict[tuple[Any, ...], pd.DataFrame]()  # trials of the baselines, by their problems and number
        self._judged: list[JsonObject] = []
        self._finals, self._lock = 0, Lock()
        self._end = finalize(self, self._workers.close)

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
        candidates = [Candidate.read(source) for source in sources]
        baselines = self._of_baselines(self._train, self._study.trials)
        frames = self._frames(self._workers, candidates, [LABEL], self._train, self._study.trials)
        return [self._found(*made, baselines) for made in zip(candidates, frames, strict=True)]

    def final(self, source: Source, *, trials: int = 10) -> Final:
        """Compare a candidate with the baselines on the held-out problems, whose first use alone is a test.

        Raises:
            BenchError: without held-out problems.
        """
        if not self._test:
            raise BenchError("there are no held-out problems: give some as 'test'")
        require_whole("trials", trials, 2)
        candidate, baselines = Candidate.read(source), self._of_baselines(self._test, trials)
        (made,) = self._frames(self._workers, [candidate], [LABEL], self._test, trials)
        frame = pd.concat([made, baselines], ignore_index=True)
        with self._lock:
            finals, judged = self._finals, len({each["hash"] for each in self._judged})
            self._finals += not candidate.error
        return Final(compare(frame, LABEL, before=True), frame, judged, finals, candidate.reason)

    def log(self, path: str | PathLike[str]) -> None:
        """Write a JSON line for each candidate judged so far: hash of its source, score and error."""
        with explained(f"{path} cannot be written"):
            Path(path).write_text("".join(f"{json.dumps(each)}\n" for each in self._judged), encoding="utf-8")

    def llamea(self, solution: Any, logger: Any = None) -> object:  # noqa: ARG002 - LLaMEA gives one
        """Judge a solution of LLaMEA or BLADE and return it with its scores: ``LLaMEA(judge.llamea, …)``.

        LLaMEA needs ``parallel_backend="threading"`` for it.
        """
        found = self(solution.code)
        solution.set_scores(found.score, found.feedback, RuntimeError(found.error) if found.error else None)
        return solution

    def evaluate(self, path: str | PathLike[str]) -> JsonObject:
        """Judge the program of a file, as the ``evaluate`` of OpenEvolve does."""
        found = self(Path(path))
        return {"combined_score": found.score, "artifacts": {"feedback": found.feedback}}

    def _of_baselines(self, problems: Sequence[str], number: int) -> pd.DataFrame:
        """Return the trials of the baselines on these problems, which are made once."""
        if not self._end.alive:
            raise BenchError("the evaluator is closed: make another one")
        with self._lock:
            if (key := (number, *problems)) not in self._known:
                installed = Candidate({})
                with closing(Workers(Task.of(self._study), self._n_jobs)) as workers:  # trusted, and without a limit
                    (frame,) = self._frames(workers, [installed], BASELINES, problems, number)
                if installed.error:
                    raise BenchError(f"a baseline failed: {installed.reason}")
                self._known[key] = frame
            return self._known[key]

    def _frames(
        self,
        workers: Workers,
        candidates: Sequence[Candidate],
        optimizers: Sequence[str],
        problems: Sequence[str],
        number: int,
    ) -> list[pd.DataFrame]:
        """Return the trials of each candidate as a tidy frame, with the AOCC of each trial."""
        planned = self._study.override(trials=number).plan()
        trials = [trial for trial in planned if trial.optimizer in optimizers and trial.problem in problems]
        trials.sort(key=lambda trial: (optimizers.index(trial.optimizer), trial.number, problems.index(trial.problem)))
        rows = workers.rows(candidates, trials)
        return [self._frame(trials, islice(rows, len(trials))) for _ in candidates]

    def _frame(self, trials: Sequence[Trial], rows: Iterable[Row]) -> pd.DataFrame:
        """Return trials as a tidy frame; those of the baselines come first and set the optima that are unknown."""
        empty = {"error": "", "fun": np.nan, "trace": b""}
        made = [trial.columns | empty | row for trial, row in zip(trials, rows, strict=True)]
        frame = pd.DataFrame(made)
        lowest: dict[Any, float] = frame.groupby("problem")["fun"].min().dropna().to_dict()
        self._optima = lowest | self._optima
        frame["aocc"] = [
            area_over_curve(Trace.unpacked(each["trace"]), self._optima.get(label, np.nan), self._budgets[label])[0]
            for label, each in zip(frame["problem"], made, strict=True)
        ]
        return frame.reindex(columns=_COLUMNS)

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
        with self._lock:
            self._judged.append({"hash": candidate.held[KEY].digest, "score": score, "error": candidate.reason})
        return Found(score, bar, candidate.reason, feedback, frame, by_problem, notes)


def _listed(problems: ProblemLike | Iterable[ProblemLike]) -> list[Any]:
    return [problems] if isinstance(problems, str) or is_plugin(problems) else [*problems]  # type: ignore[misc]
