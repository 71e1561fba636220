"""The optimizer under check, in a form from which another process can construct it."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, get_type_hints

import cloudpickle

from bench.check.conformance.recording import RecordedRun, record_run
from bench.errors import BenchError
from bench.numbers import require_whole
from bench.optimizer import Optimizer, build, settings
from bench.plugins.loading import load_optimizer
from bench.problem import Problem
from bench.sandbox.process import Pulse

START_PATIENCE = 120.0
"""Seconds without a sign of life that are allowed while a process imports, compiles and makes its first run."""


@dataclasses.dataclass(frozen=True)
class Subject:
    """An optimizer that is constructed anew for every run, so that no run depends on the state that another one left.

    Attributes:
        source: its name, its class, or an instance of it.
        options: its parameters, for a name or a class.
        seed: the first seed of its runs.
        packed: the bytes that :func:`pack` made before its first run, where known.
        pulse: see :func:`bench.check.conformance.recording.record_run`.
        expendable: likewise.
    """

    source: str | type[Optimizer] | Optimizer
    options: dict[str, Any] = dataclasses.field(default_factory=dict)
    seed: int = 0
    packed: bytes | None = None
    pulse: Pulse | None = None
    expendable: bool = False

    @property
    def label(self) -> str:
        """The name that verdicts show."""
        if isinstance(self.source, str):
            return self.source
        cls = self.source if isinstance(self.source, type) else type(self.source)
        return cls.__name__

    def fresh(self) -> Optimizer:
        """Return a new instance with these parameters; raises whatever its construction raises."""
        if isinstance(self.source, str):
            return load_optimizer(self.source, **self.options)
        if isinstance(self.source, type):
            return self.source(**self.options)
        copy: Optimizer = pickle.loads(cloudpickle.dumps(self.source))
        return copy

    def run(
        self,
        problem: Problem,
        *,
        optimizer: Optimizer | None = None,
        budget: int | None = None,
        seed: int = 0,
        global_seed: int = 0,
    ) -> RecordedRun:
        """Run a new instance, or ``optimizer``; see :func:`bench.check.conformance.recording.record_run`.

        Args:
            problem: what is minimised.
            optimizer: an instance to run instead of a new one.
            budget: evaluations it may spend; by default those of an ordinary run.
            seed: added to the subject's own.
            global_seed: of the global random states.
        """
        optimizer = optimizer if optimizer is not None else self.fresh()
        return record_run(
            optimizer,
            problem,
            budget if budget is not None else ordinary_budget(optimizer),
            seed=self.seed + seed,
            pulse=self.pulse,
            expendable=self.expendable,
            global_seed=global_seed,
        )


def make_subject(optimizer: object, options: dict[str, Any], seed: int) -> Subject:
    """Return the subject of a name, a class or an instance.

    Raises:
        BenchError: for anything else, for an unknown name, for options of an instance, and for a seed below 0.
    """
    require_whole("the seed", seed, 0)
    if isinstance(optimizer, str):
        _refuse(lambda: load_optimizer(optimizer, **options))
        return Subject(optimizer, options, seed)
    if isinstance(optimizer, type) and issubclass(optimizer, Optimizer):
        if options:
            _refuse(lambda: build(optimizer, optimizer.__name__, options))
        return Subject(vars(optimizer).get("plugin", optimizer), options, seed)
    if not isinstance(optimizer, Optimizer):
        raise BenchError(
            f"give the name of an optimizer, an Optimizer subclass or an instance of one, not {optimizer!r}"
        )
    if options:
        raise BenchError(
            f"{next(iter(options))!r} cannot be set: the optimizer is made already; give its class or name"
        )
    if "plugin" in vars(type(optimizer)):  # a class made at run time is loaded by its name
        own = settings(optimizer)
        return Subject(vars(type(optimizer))["plugin"], own, seed)
    return Subject(optimizer, {}, seed)


def _refuse(make: Callable[[], Optimizer]) -> None:
    """Raise BenchError for bad input; other exceptions of a plug-in are for the rule of the parameters to report."""
    try:
        make()
    except BenchError:
        raise
    except Exception:
        return


def ordinary_budget(optimizer: Optimizer) -> int:
    """Return the budget of an ordinary run: a few generations, the last one cut short."""
    return max(150, 4 * optimizer.minimum_budget + 3)


def parameters(optimizer: Optimizer) -> dict[str, str]:
    """Return the optimizer's fields as text, or all attributes where it has no fields."""
    if dataclasses.is_dataclass(optimizer):
        return {name: repr(value) for name, value in settings(optimizer).items()}
    return {name: repr(value) for name, value in vars(optimizer).items()}


def pack(subject: Subject) -> bytes:
    """Return the subject as bytes; a class that another process cannot import is sent by value.

    Raises:
        Exception: whatever a parameter, or an object that a local class uses, raises on pickling.
    """
    cls = subject.source if isinstance(subject.source, type) else type(subject.source)
    local = [each for each in cls.__mro__ if not _importable(each)]
    with _by_value({each.__module__ for each in local}):
        plain = dataclasses.replace(subject, packed=None, pulse=None, expendable=False)
        return bytes(cloudpickle.dumps((plain, [(each, _annotations(each)) for each in local])))


@lru_cache(maxsize=1)
def unpack(packed: bytes) -> Subject:
    """Return the subject of :func:`pack`."""
    subject, annotations = pickle.loads(packed)
    for cls, types in annotations:
        # annotations in the form of strings are looked up in the class's module, which this process does not have
        cls.__annotations__ = types
    return dataclasses.replace(subject, packed=packed)  # type: ignore[no-any-return]


def _annotations(cls: type) -> dict[str, Any]:
    """Return the class's own annotations as types; unchanged where one of them cannot be evaluated."""
    own = inspect.get_annotations(cls)
    try:
        hints = get_type_hints(cls)
    except Exception:  # the rule of the parameters reports it
        return own
    return {name: hints[name] for name in own if "ClassVar" not in str(own[name])}


def _importable(cls: type) -> bool:
    """Return whether a new process finds the class where this one did; ``__main__`` is another module there."""
    module = sys.modules.get(cls.__module__)
    if module is None or module.__name__ == "__main__" or "<locals>" in cls.__qualname__:
        return False
    spec, path, parts = None, None, cls.__module__.split(".")
    for depth in range(len(parts)):
        found = (finder.find_spec(".".join(parts[: depth + 1]), path) for finder in sys.meta_path)
        spec = next(filter(None, found), None)
        if spec is None:
            return False
        path = spec.submodule_search_locations
    return spec is not None and spec.origin in ("built-in", "frozen", getattr(module, "__file__", None))


@contextmanager
def _by_value(modules: set[str]) -> Iterator[None]:
    chosen = [sys.modules[name] for name in modules - {"__main__"} if name in sys.modules]
    for module in chosen:
        cloudpickle.register_pickle_by_value(module)
    try:
        yield
    finally:
        for module in chosen:
            cloudpickle.unregister_pickle_by_value(module)
