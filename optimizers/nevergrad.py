"""The optimizers of nevergrad's registry, as ``"nevergrad:DE"``, ``"nevergrad:TwoPointsDE"``, …"""

from __future__ import annotations

import inspect
import threading
import types
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from types import ModuleType
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np

from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, parameter
from bench.contract.typing import Options
from bench.helpers.errors import BenchError
from optimizers.common.family import Adapter, Family, global_random_state, table

TABLE = table("nevergrad")
SCALARS = (bool, int, float, str, types.NoneType)


@dataclass(frozen=True)
class NevergradOptimizer(Adapter):
    """An optimizer of nevergrad's registry, run by its ask and tell.

    Attributes:
        workers: the number of points that are evaluated in one batch (nevergrad: num_workers).
        start: the centre of nevergrad's search space: ``"random"``, a point of ``objective.initial``, or the
            ``"midpoint"`` of the box, nevergrad's own default.

    The scalar settings of a configurable optimizer are parameters too, under nevergrad's names; only its ``popsize``
    is called ``agents``, where None keeps the registry's value, which may be a rule such as ``"standard"``.
    """

    workers: int = parameter(1, minimum=1)
    start: Literal["random", "midpoint"] = "random"

    def __post_init__(self) -> None:
        """Check the parameters, by nevergrad's own rules too; raises BenchError for one that does not fit."""
        super().__post_init__()
        if self.workers == 1 and not self._changed():
            return
        import nevergrad

        if self.workers > 1 and registered(self.member).no_parallelization:
            raise BenchError(f"nevergrad's {self.member} takes one point after the other: its workers must be 1")
        try:
            with global_random_state(np.random.default_rng(0)), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self._make(nevergrad.p.Array(shape=(2,), lower=-1, upper=1), budget=100)
        except Exception as error:  # its optimizers assert and raise as they like
            reason = (str(error) or type(error).__name__).splitlines()[0]
            raise BenchError(f"nevergrad refuses these parameters of {self.member}: {reason}") from error

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Minimise until the budget is spent."""
        import nevergrad

        with (
            global_random_state(rng), settings_restored(), threads_ended(),
            redirect_stdout(StringIO()), warnings.catch_warnings(),
        ):  # fmt: skip
            warnings.simplefilter("ignore")
            midpoint = (objective.lower + objective.upper) / 2
            centre = midpoint if self.start == "midpoint" else objective.start_point()
            space = nevergrad.p.Array(init=centre, lower=objective.lower, upper=objective.upper)
            space.random_state = np.random.RandomState(int(rng.integers(2**32)))
            try:
                optimizer = self._make(space, objective.budget)
                while objective.remaining:
                    asked = [optimizer.ask() for _ in range(min(self.workers, objective.remaining))]
                    values = self.values(objective, np.array([candidate.value for candidate in asked]))
                    for candidate, value in zip(asked, values, strict=True):
                        optimizer.tell(candidate, float(value))
            except (ImportError, RuntimeError) as error:  # a thread's error comes as the cause of another
                cause = error.__cause__ or error
                if not isinstance(cause, ImportError):
                    raise
                raise BenchError(
                    f"nevergrad's {self.member} needs a package here that is not installed: {cause}"
                ) from error

    def _changed(self) -> Options:
        """Return the settings that differ from the registry's, under nevergrad's names."""
        chosen = self.options()
        if chosen.get("popsize", 0) is None:  # agents=None sets nothing
            del chosen["popsize"]
        settings = registered(self.member).config() if chosen else {}
        return {key: value for key, value in chosen.items() if value != settings[key]}

    def _make(self, space: object, budget: int) -> Any:
        """Return nevergrad's optimizer of the space, with the parameters of this instance."""
        maker = registered(self.member)
        if changed := self._changed():
            maker = type(maker)(**maker.config() | changed)
        return maker(space, budget, self.workers)


def registered(member: str) -> Any:
    """Return an optimizer of the registry: a class, or an object that makes an optimizer from its settings."""
    import nevergrad

    return nevergrad.optimizers.registry[member]


def scalar(hint: object) -> object:
    """Return the scalar types of a type hint as a hint, or None without any."""
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    kept = tuple(option for option in options if option in SCALARS)
    return Union[kept] if set(kept) - {types.NoneType} else None  # noqa: UP007 - made at run time


@contextmanager
def threads_ended() -> Iterator[None]:
    """End the threads in which nevergrad runs optimizers that call a function themselves."""
    from nevergrad.optimization.recaster import _MessagingThread

    before = set(threading.enumerate())
    try:
        yield
    finally:
        for thread in set(threading.enumerate()) - before:
            while isinstance(thread, _MessagingThread) and thread.is_alive():
                thread.stop()
                thread.join(0.1)


@contextmanager
def settings_restored() -> Iterator[None]:
    """Restore the setting that all runs of CMA-ES share, into which nevergrad writes in one dimension."""
    from nevergrad.optimization.optimizerlib import ParametrizedCMA

    before: list[tuple[ParametrizedCMA, bool]] = []

    def remember(family: ParametrizedCMA, name: str, value: object) -> None:
        if name == "fcmaes" and hasattr(family, name):
            before.append((family, family.fcmaes))
        object.__setattr__(family, name, value)

    ParametrizedCMA.__setattr__ = remember
    try:
        yield
    finally:
        del ParametrizedCMA.__setattr__
        for family, value in reversed(before):
            family.fcmaes = value


class Nevergrad(Family):
    """The family ``nevergrad:<name>``: nevergrad's registry of optimizers and their combinations."""

    name = "nevergrad"
    module = "nevergrad"
    extra = "nevergrad"
    facts = TABLE

    def require(self) -> ModuleType:
        """Return nevergrad; its import draws random numbers, here from a fixed seed and without a trace."""
        with global_random_state(np.random.default_rng(0)), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return super().require()

    def members(self) -> list[str]:
        """Return the names of the registry but those left out."""
        names = self.require().optimizers.registry
        return [name for name in names if name.isidentifier() and not self.why_left_out(name)]

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of a member; its parameters are the settings that are scalars."""
        maker = registered(member)
        settings = {} if isinstance(maker, type) else maker.config()
        signature = inspect.signature(type(maker).__init__).parameters if settings else {}
        hints = {key: scalar(signature[key].annotation) for key in settings}
        scalars: dict[str, tuple[object, object]] = {
            key: (hint, settings[key]) for key, hint in hints.items() if hint and isinstance(settings[key], SCALARS)
        }
        if "popsize" in scalars:
            size = scalars.pop("popsize")[1]
            scalars["popsize"] = (int | None, parameter(size if isinstance(size, int) else None, minimum=4))
        kept = [key for key in settings if key not in scalars and key != "popsize"]
        unmapped = (f"the parameter {key!r} is no scalar and keeps nevergrad's value" for key in kept)
        return self.member_class(
            NevergradOptimizer, member, scalars,
            (*TABLE["works"].get(type(maker).__name__, ()), "rapin2018", "bennet2021"),
            libraries=("nevergrad", "cma"),  # many members are a CMA-ES in part
            unmapped=(*TABLE["unmapped"], *unmapped), __doc__=about(member, maker),
        )  # fmt: skip


def about(member: str, entry: Any) -> str:
    """Describe an optimizer of the registry in one line: its own docstring, or its class and settings."""
    if isinstance(entry, type):
        lines = (entry.__doc__ or "").strip().splitlines()
        return lines[0] if lines else f"Nevergrad's {member}, derived from its {entry.__bases__[0].__name__}."
    defaults = {key: argument.default for key, argument in inspect.signature(type(entry).__init__).parameters.items()}
    settings = ", ".join(f"{key}={value!r}" for key, value in entry.config().items() if value != defaults[key])
    return f"Nevergrad's {type(entry).__name__}({settings})."


nevergrad = Nevergrad()
