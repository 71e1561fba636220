"""Supervise trial processes from a worker: start and restart them, and turn hangs, crashes and excess into rows."""

from __future__ import annotations

import json
import os
import signal
import threading
from dataclasses import dataclass, field
from time import monotonic, sleep
from typing import Any

from bench.errors import BenchError
from bench.execution import trial_process
from bench.execution.trial_process import failed
from bench.sandbox.process import DiedError, MemoryExceededError, Process, RemoteError, SilentError
from bench.sandbox.server import UNANSWERABLE
from bench.storage import provenance
from bench.study import Fingerprints
from bench.trial import Row, Trial

LOADING = 20.0  # seconds, added to the limit of a trial, allowed between two imports of a plug-in
WARMING = 3.0  # minimum seconds allowed for a warm-up, without imports and compilation
PRINTED = 1_000_000  # bytes that a trial may print: they are discarded, but reading them takes time from other trials
CHECKING = 60.0  # seconds allowed without a sign of life while a study's plug-ins are first loaded
DEATHS = 3  # of the process that loads them, by signals from outside, before the study is given up
FULL = 0.5  # share of the memory allowed; a process that holds more between trials is ended, to spare the next trial
KILLED = [-getattr(signal, name) for name in ("SIGKILL", "SIGTERM") if hasattr(signal, name)]
"""Exit codes after a kill from outside: by the system when memory runs out, or by a person."""

_SHORT = 0.01  # seconds; a shorter trial cannot fill much memory, and each look takes 0.1 ms
_LOOK = 0.5  # seconds between looks for the parent, and minimum seconds between looks at a process's memory


@dataclass(frozen=True)
class Task:
    """What every trial of a run has in common."""

    study: str  # as TOML, so that workers load plug-ins by name as the parent does
    timeout: float | None = None  # wall seconds that a trial may take
    memory: int | None = None  # bytes that a trial's process may hold
    hash_seed: int = 0  # PYTHONHASHSEED of trial processes, which orders sets of strings
    package: str = field(default_factory=provenance.package)  # of the parent; a worker with another one is refused


def work(task: Task, trial: Trial) -> tuple[Trial, Row, str]:
    """Have one trial made; return it with its row and its machine's record (:func:`bench.storage.provenance.machine`).

    Raises:
        BenchError: when this worker has another version of the package than the parent.
    """
    own = provenance.package()
    if own != task.package:
        raise BenchError(
            f"a worker on {provenance.host()} runs {own}, the run itself {task.package}; install the same version on "
            "both"
        )
    supervisor = _supervisor(task)
    return trial, supervisor.make(trial), supervisor.machine()


def check(task: Task, *, keep: bool = False) -> Fingerprints:
    """Run :meth:`bench.study.Study.check` in a trial process, so that no plug-in is loaded into this one.

    With ``keep``, the process is kept for trials that are made here, until :func:`close`.

    Raises:
        BenchError: for the first name, parameter, recording or budget that cannot work, or for plug-ins that hang or
            crash while they are loaded.
    """
    loading = "loading the study's problems and optimizers"
    try:
        found = _supervisor(task).check()
    except SilentError as error:
        raise BenchError(
            f"{loading} hangs: no sign of life for {error}; try each with 'bench solve' to find which"
        ) from error
    except (DiedError, RemoteError, MemoryExceededError) as error:
        raise BenchError(f"{loading} failed: {error}") from error
    finally:
        if not keep:
            close()
    if isinstance(found, str):
        raise BenchError(found)
    return Fingerprints(*found)


def end_with_parent(parent: int) -> None:
    """End this worker when its parent has ended, such as by a kill; ignore Ctrl-C, which the parent handles."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            sleep(_LOOK)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def close() -> None:
    """End the trial processes of all threads of this process."""
    for supervisor in list(_supervisors.values()):
        supervisor.close()


def _supervisor(task: Task) -> _Supervisor:
    """Return the supervisor of this thread, set to the task."""
    supervisor = _supervisors.setdefault(threading.get_ident(), _Supervisor(task))
    supervisor.set_task(task)
    return supervisor


class _Supervisor:
    """Supervises the one trial process of one thread, and starts another when it is lost."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self._process: Process | None = None
        self._ready: set[tuple[str, str]] = set()  # cells loaded and warmed up in the present process
        self._slow_to_warm: set[tuple[str, str]] = set()  # cells whose warm-up took too long: it is not repeated
        self._machine = ""
        self._next_look = 0.0  # time of the next look at the process's memory

    def set_task(self, task: Task) -> None:
        """Change to another task; keep the process unless the hash seed differs."""
        if task.hash_seed != self.task.hash_seed:
            self.close()
        if task.study != self.task.study:
            self._machine = ""
            self._ready.clear()
            self._slow_to_warm.clear()
        self.task = task

    def check(self) -> Any:
        """Return the answer of :func:`trial_process.check`; replace a process that is killed from outside."""
        for left in reversed(range(DEATHS)):
            try:
                return self._call(trial_process.check, patience=CHECKING)
            except DiedError as error:
                self.close()
                if error.code not in KILLED or not left:
                    raise
        raise AssertionError("the last death is raised")

    def close(self) -> None:
        """End the process; any thread may do so."""
        process, self._process = self._process, None  # first, as the supervised thread may start a new one meanwhile
        self._ready.clear()
        if process is not None:
            process.close()

    def machine(self) -> str:
        """Return the machine's record as JSON (:func:`bench.storage.provenance.machine`)."""
        if not self._machine:
            sound = False
            try:
                self._machine, sound = self._call(trial_process.describe_machine, patience=self._patience(LOADING))
            except (SilentError, DiedError, RemoteError, MemoryExceededError):
                self._machine = json.dumps(provenance.machine())
            finally:
                if not sound:
                    self.close()
        return self._machine

    def make(self, trial: Trial) -> Row:
        """Return the row of a trial, whether it finishes, fails or times out.

        A trial whose process is killed from outside is begun once more, as that may not be the trial's fault.
        """
        row = self._make(trial)
        return row if row is not None else self._make(trial, last=True) or failed("its process was killed twice")

    def _make(self, trial: Trial, last: bool = False) -> Row | None:
        timeout, cell = self.task.timeout, (trial.problem, trial.optimizer)
        doing, sound = "", False
        try:
            self.machine()
            if cell not in self._ready:
                doing = "while its plug-ins were loaded"
                self._call(trial_process.load, *cell, patience=self._patience(LOADING))
                if cell not in self._slow_to_warm:
                    doing = "in its warm-up, a short trial before the first"
                    self._slow_to_warm.add(cell)
                    self._call(trial_process.warm_up, *cell, patience=self._patience(at_least=WARMING))
                    self._slow_to_warm.discard(cell)
                self._ready.add(cell)
            doing = ""
            began = monotonic()
            row, sound = self._call(trial_process.make, trial, patience=timeout)
            sound = sound and not self._is_full(monotonic() - began)
            process = self._process  # a local name, as another thread may close it
            if row["status"] == "ok" and process is not None and process.printed > PRINTED:
                return failed(f"printed more than {PRINTED / 1e6:g} MB; have it print less, as by verbose=False")
            return dict(row)
        except SilentError as error:
            where = (
                f"{doing}, after {error} without a sign of life" if doing else f"after {error}, the limit of a trial"
            )
            return {"status": "timeout", "error": f"stopped {where} (--timeout)"}
        except MemoryExceededError as error:
            return failed(f"{error} (--memory)")
        except DiedError as error:
            if error.code in KILLED and not last:
                return None
            return failed(_why_it_ended(error))
        except RemoteError as error:
            return failed(str(error))
        finally:
            if not sound:
                self.close()

    def _is_full(self, seconds: float) -> bool:
        """Return whether the process holds too much memory for another trial, after a trial of ``seconds``."""
        limit, process, now = self.task.memory, self._process, monotonic()
        if limit is None or process is None or (seconds < _SHORT and now < self._next_look):
            return False
        self._next_look = now + _LOOK
        return process.resident > FULL * limit

    def _patience(self, beside: float = 0.0, at_least: float = 0.0) -> float | None:
        return None if self.task.timeout is None else max(self.task.timeout + beside, at_least)

    def _call(self, function: Any, *arguments: Any, patience: float | None) -> Any:
        process = self._process
        if process is None:
            process = self._process = Process(self.task.hash_seed)
        return process.call(function, self.task.study, *arguments, patience=patience, memory=self.task.memory)


def _why_it_ended(error: DiedError) -> str:
    """Return why a trial's process ended."""
    if error.code == trial_process.STILL_ASKING:
        return "went on asking for values after its budget was spent; let BudgetExhausted pass"
    if error.code == UNANSWERABLE:
        return "closed files that are not its own, through which its process answers"
    twice = " twice; the machine may be short of memory" if error.code in KILLED else ""
    output = f"\n{error.end_of_output}" if error.end_of_output else ""
    return f"its process ended with {error}{twice}{output}"


_supervisors: dict[int, _Supervisor] = {}
