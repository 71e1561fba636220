"""In a worker: have trials made by a process of their own, which a plug-in may hang, fill or crash at its own cost."""

from __future__ import annotations

import json
import signal
import threading
from dataclasses import dataclass, field
from typing import Any

from bench import environment, worker
from bench.errors import BenchError
from bench.process import DiedError, MemoryExceededError, Process, RemoteError, SilentError
from bench.study import Trial
from bench.worker import Row, failed

LOADING = 20.0  # seconds beside the limit of a trial in which plug-ins are loaded and warmed up, compilation aside
KILLED = (-signal.SIGKILL, -signal.SIGTERM)  # what comes from outside: the system short of memory, or a person


@dataclass(frozen=True)
class Task:
    """What every trial of a run has in common.

    Attributes:
        study: the study as TOML: a study's text is its pickle, and workers load plug-ins by name as the parent does.
        timeout: wall seconds that a trial may take, or None.
        memory: bytes of memory that a trial's process may hold, or None.
        hash_seed: of the process, which orders sets of texts.
        package: :func:`bench.environment.package` of the parent; a worker with another one is refused.
    """

    study: str
    timeout: float | None = None
    memory: int | None = None
    hash_seed: int = 0
    package: str = field(default_factory=environment.package)


def work(task: Task, trial: Trial) -> tuple[Trial, Row, str]:
    """Have one trial made; return it with its row and the worker's :func:`bench.environment.machine` as JSON.

    Raises:
        BenchError: when this worker has another version of the package than the parent.
    """
    require(task.package)
    me = threading.get_ident()
    keeper = _keepers.get(me)
    if keeper is None or keeper.task != task:
        if keeper is not None:
            keeper.close()
        keeper = _keepers[me] = _Keeper(task)
    return trial, keeper.make(trial), keeper.machine()


def require(package: str) -> None:
    """Raise BenchError where this process runs another package than the one named."""
    own = environment.package()
    if own != package:
        raise BenchError(
            f"a worker on {environment.host()} runs {own}, the run itself {package}; install the same version on both"
        )


def close() -> None:
    """End the trial processes of all this process's threads."""
    for keeper in list(_keepers.values()):
        keeper.close()


class _Keeper:
    """Keeps one trial process for one thread, and starts another one when it is lost."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self._process: Process | None = None
        self._prepared: set[tuple[str, str]] = set()  # cells, in the process as it is
        self._late: set[tuple[str, str]] = set()  # cells whose warm-up took too long: they go on without
        self._machine = ""

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.close()
        self._process = None
        self._prepared.clear()

    def machine(self) -> str:
        """Return what the trials are made by, as JSON."""
        if not self._machine:
            try:
                self._machine = self._ask(worker.describe, patience=self._patience())
            except (SilentError, DiedError, RemoteError, MemoryExceededError):
                self.close()
                self._machine = json.dumps(environment.machine())
        return self._machine

    def make(self, trial: Trial) -> Row:
        """Return the row of a trial, whatever becomes of it.

        A trial whose process is killed from outside is begun once more: it may be no fault of its own.
        """
        row = self._make(trial)
        return row if row is not None else self._make(trial, last=True) or failed("its process was killed twice")

    def _make(self, trial: Trial, last: bool = False) -> Row | None:
        timeout, cell = self.task.timeout, (trial.problem, trial.optimizer)
        sound = False
        try:
            if not self._machine:
                self.machine()
            if cell not in self._prepared | self._late:
                try:
                    self._ask(worker.prepare, *cell, patience=self._patience())
                except SilentError:
                    self._late.add(cell)
                    raise
                self._prepared.add(cell)
            row, sound = self._ask(worker.make, trial, patience=timeout)
        except SilentError:
            return {"status": "timeout", "error": f"stopped after {timeout:g} s, the limit of a trial (--timeout)"}
        except MemoryExceededError as error:
            return failed(f"{error} (--memory)")
        except DiedError as error:
            if error.code in KILLED and not last:
                return None
            return failed(_obituary(error))
        except RemoteError as error:
            return failed(str(error))
        finally:
            if not sound:
                self.close()
        return dict(row)

    def _patience(self) -> float | None:
        return None if self.task.timeout is None else self.task.timeout + LOADING

    def _ask(self, function: Any, *arguments: Any, patience: float | None) -> Any:
        if self._process is None:
            self._process = Process(self.task.hash_seed)
        return self._process.call(function, self.task.study, *arguments, patience=patience, memory=self.task.memory)


def _obituary(error: DiedError) -> str:
    """Return why a trial's process ended."""
    if error.code == worker.STILL_ASKING:
        return "went on asking for values after its budget was spent; let BudgetExhausted pass"
    twice = " twice; the machine may be short of memory" if error.code in KILLED else ""
    words = f"\n{error.last_words}" if error.last_words else ""
    return f"its process ended with {error}{twice}{words}"


_keepers: dict[int, _Keeper] = {}
