"""The plug-in under check, in a form from which another process can make it; and an optimizer."""

from __future__ import annotations

import dataclasses
import pickle
from abc import ABC, abstractmethod
from functools import lru_cache
from typing import Any, ClassVar, Self

import cloudpickle
from threadpoolctl import threadpool_limits

from bench.check.conformance.recording import ObservedOptimizer, Progress, RecordedRun, seeded_global_states
from bench.check.problems import RecordingProblem, bowl
from bench.contract.numbers import require_seed
from bench.contract.optimizer import Optimizer, build, settings
from bench.contract.typing import Options
from bench.helpers.errors import BenchError
from bench.plugins import packing
from bench.plugins.loading import load_optimizer, title
from bench.sandbox.server import end_if_stuck
from bench.trial.trial import search

START_SECONDS = 120.0
"""Seconds that a process may take to import the optimizer, to compile it and to make a few first runs."""


@dataclasses.dataclass(frozen=True)
class AnySubject(ABC):
    """A plug-in under check, made anew for every run, so that runs share no state.

    The rules that hold for optimizers and problems know no more of it.

    Attributes:
        kind: ``"optimizer"`` or ``"problem"``, whose table of rules it is checked against.
        base: the class that all plug-ins of the kind have.
        source: its name, its class, or an instance of it.
        options: its parameters or options, for a name or a class.
        seed: the first seed of its runs.
        packed: the bytes from which :func:`unpack` made it, in a process that may be ended; None elsewhere.
    """

    kind: ClassVar[str]
    base: ClassVar[type]
    source: object
    options: Options = dataclasses.field(default_factory=dict)
    seed: int = 0
    packed: bytes | None = None

    @classmethod
    def of(cls, plugin: object, options: Options, seed: int) -> Self:
        """Return the subject of a name, a class or an instance; what a name stands for is made once.

        Raises:
            BenchError: for anything else, for an unknown name, for options of an instance, and for a seed below 0.
        """
        require_seed("the seed", seed)
        made = isinstance(plugin, cls.base)
        if not (made or isinstance(plugin, str) or (isinstance(plugin, type) and issubclass(plugin, cls.base))):
            raise BenchError(
                f"give the name of a plug-in of bench.{cls.kind}s, a subclass of {cls.base.__name__} or an instance of "
                f"one, not {plugin!r}"
            )
        if made and options:
            raise BenchError(
                f"{next(iter(options))!r} cannot be set: the {cls.kind} is made already; give its class or name"
            )
        kind = type(plugin) if made else plugin
        if isinstance(kind, type) and "plugin" in vars(kind):  # made at run time, so it is loaded by its name
            plugin, options = vars(kind)["plugin"], settings(plugin) if isinstance(plugin, Optimizer) else options
        subject = cls(plugin, options, seed)
        if not made and (options or isinstance(plugin, str)):
            try:
                subject.fresh()
            except BenchError:
                raise
            except Exception:  # the first rule reports it
                return subject
        return subject

    @property
    def label(self) -> str:
        """The name that verdicts show."""
        return self.source if isinstance(self.source, str) else title(self.source)

    @abstractmethod
    def fresh(self) -> Any:
        """Return a new instance with these options; raises whatever its construction raises."""

    @abstractmethod
    def run(self, *, instance: Any = None, seed: int = 0, global_seed: int = 0) -> RecordedRun:
        """Use a new instance, or ``instance``, as a trial does, and return the record."""

    @abstractmethod
    def parameters(self, plugin: Any, /) -> dict[str, str]:
        """Return the declaration of an instance as text."""


@dataclasses.dataclass(frozen=True)
class Subject(AnySubject):
    """An optimizer under check."""

    kind = "optimizer"
    base = Optimizer

    def fresh(self) -> Optimizer:
        """Return a new instance with these parameters; raises whatever its construction raises."""
        if isinstance(self.source, str):
            return load_optimizer(self.source, **self.options)
        if isinstance(self.source, type):
            return build(self.source, self.label, self.options) if self.options else self.source()
        copy: Optimizer = pickle.loads(cloudpickle.dumps(self.source))
        return copy

    def run(
        self,
        problem: RecordingProblem | None = None,
        *,
        instance: Optimizer | None = None,
        budget: int | None = None,
        seed: int = 0,
        global_seed: int = 0,
    ) -> RecordedRun:
        """Run a new instance, or ``optimizer``, as a trial does and return the record.

        Args:
            problem: what is minimised, a new one for every run; by default the ordinary problem.
            instance: an optimizer to run instead of a new one.
            budget: evaluations it may spend; by default those of an ordinary run.
            seed: added to the subject's own.
            global_seed: of Python's and numpy's global random states during the run.
        """
        problem = problem if problem is not None else bowl()
        optimizer = instance if instance is not None else self.fresh()
        budget = budget if budget is not None else ordinary_budget(optimizer)
        run, progress = RecordedRun(), Progress(budget)
        observed = ObservedOptimizer(optimizer, run, progress)

        def on_refusal(number: int) -> None:
            run.asked_after = number - 1
            if number == 1:
                progress.report(budget)
            end_if_stuck(number)

        with threadpool_limits(limits=1), seeded_global_states(global_seed) as changed:
            try:
                run.stop = search(problem, observed, budget, self.seed + seed, on_refusal).stop
            except RuntimeError:  # without a single evaluation
                if not observed.returned:
                    raise
        run.points, run.touched = problem.points, tuple(changed)
        return run

    def parameters(self, optimizer: Optimizer) -> dict[str, str]:
        """Return the optimizer's fields as text, or all attributes where it has no fields."""
        values = settings(optimizer) if dataclasses.is_dataclass(optimizer) else vars(optimizer)
        return {name: repr(value) for name, value in values.items()}


def ordinary_budget(optimizer: Optimizer) -> int:
    """Return the budget of an ordinary run: a few generations, the last one cut short."""
    return max(150, 4 * optimizer.minimum_budget + 3)


def pack(subject: AnySubject) -> bytes:
    """Return the subject as bytes, including a class that no other process can import; raises what pickling raises."""
    try:
        return packing.pack(dataclasses.replace(subject, packed=None)).content
    except BenchError as error:
        raise error.__cause__ or error from None


@lru_cache(maxsize=1)
def unpack(packed: bytes) -> Any:
    """Return the subject of :func:`pack`."""
    return dataclasses.replace(packing.unpack(packed), packed=packed)
