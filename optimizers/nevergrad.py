"""The optimizers of nevergrad's registry, as ``"nevergrad:DE"``, ``"nevergrad:NGOpt"``, …"""

from __future__ import annotations

import inspect
import threading
import time
import types
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from copy import copy
from dataclasses import dataclass
from importlib.metadata import version
from io import StringIO
from typing import Any, ClassVar, Literal, Union, get_args, get_origin

import numpy as np

from bench.errors import BenchError
from bench.objective import Objective
from bench.optimizer import Optimizer, parameter
from bench.plugins.derived import derive
from optimizers.cma_es import CMAES
from optimizers.common.bibtex import STORN
from optimizers.common.family import Adapter, Family, global_random_state

LIBRARY = """
    @misc{rapin2018,
      author = {Rapin, Jeremy and Teytaud, Olivier},
      title = {{Nevergrad}: A gradient-free optimization platform},
      howpublished = {https://GitHub.com/FacebookResearch/Nevergrad},
      year = {2018},
    }
    @article{bennet2021,
      author = {Bennet, Pauline and Doerr, Carola and Moreau, Antoine and Rapin, Jeremy and Teytaud, Fabien and
                Teytaud, Olivier},
      title = {{Nevergrad}: black-box optimization platform},
      journal = {ACM SIGEVOlution},
      volume = {14},
      number = {1},
      pages = {8--15},
      year = {2021},
      doi = {10.1145/3460310.3460312},
    }
"""
LINEAGE = {"DifferentialEvolution": STORN, "ParametrizedCMA": CMAES.bibtex}
"""The works that nevergrad's configurable classes come from, where known."""

NEED_PACKAGES = {
    "AX", "AXP", "BOBYQA", "BayesOptimBO", "NGOptF", "NGOptF2", "NGOptF3", "NGOptF5", "PCABO", "PCABO80",
    "PCABO95DoE20", "PymooBIPOP", "PymooCMAES", "PymooNSGA2", "SMAC3", "pysot",
}  # fmt: skip
"""They need packages which nevergrad does not install, or versions long gone; so do all FCMA… and NLOPT_….

NGOptF2 and NGOptF5 need them at times only, but follow the order of a set, which differs from process to process.
"""

CLOCKED = {"VoxelizeMetaModelOnePlusOne"}
"""It trains a network for seven seconds of the clock, so that no seed repeats its runs."""

STUCK = {"NgIohLn", "NgIohMLn", "NgIohRS"}
"""They ask a thread twice for a point, which waits for ever (and here ends in an error)."""

SLOW = {"BO", "BOSplit", "NGOptSingle25"}
"""They compute for more than 20 s over 500 evaluations in three dimensions; so do all RF1…."""

EXCLUDED = NEED_PACKAGES | CLOCKED | STUCK | SLOW
PREFIXES = ("FCMA", "NLOPT_", "RF1")

SCALARS = (bool, int, float, str, types.NoneType)

UNMAPPED = (
    "one point of the harness is the centre of its search space; its start population, if any, is nevergrad's own",
    "values above 5e20, such as +inf, are 5e20 to it",
    "in one dimension what leads to CMA-ES needs a package that nevergrad does not install (fcmaes or pybobyqa)",
)


@dataclass(frozen=True)
class NevergradOptimizer(Adapter):
    """An optimizer of nevergrad's registry, asked for points and told their values.

    Attributes:
        workers: the points asked for before any is told, which are evaluated in one batch (nevergrad: num_workers).
        start: the centre of nevergrad's search space: ``"random"``, a point of ``objective.initial``, or the
            ``"midpoint"`` of the box, as it is for nevergrad's users who give none.

    A configurable optimizer's scalar settings are parameters too, under nevergrad's names but for ``agents``, which is
    its ``popsize``; None leaves that to the registry, whose value may be a rule such as ``"standard"``.
    """

    workers: int = parameter(1, minimum=1)
    start: Literal["random", "midpoint"] = "random"

    member: ClassVar[str]  # its name in the registry
    mapped: ClassVar[dict[str, str]] = {}  # a parameter's name here, and nevergrad's

    def __post_init__(self) -> None:
        """Check the parameters; raises BenchError for what nevergrad refuses, too."""
        super().__post_init__()
        if self.workers == 1 and not self._changed():
            return
        import nevergrad

        if self.workers > 1 and nevergrad.optimizers.registry[self.member].no_parallelization:
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

        with global_random_state(rng), in_step(), redirect_stdout(StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            midpoint = (objective.lower + objective.upper) / 2
            centre = midpoint if self.start == "midpoint" else objective.initial(1)[0]
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

    def _changed(self) -> dict[str, Any]:
        """Return the settings that differ from the registry's, by nevergrad's names."""
        registered = configuration(self.member)
        given = {theirs: getattr(self, ours) for ours, theirs in self.mapped.items()}
        return {key: value for key, value in given.items() if value != registered[key] and (key, value) != NO_AGENTS}

    def _make(self, space: Any, budget: int) -> Any:
        """Return nevergrad's optimizer of the space, with this one's parameters."""
        import nevergrad

        found: Any = nevergrad.optimizers.registry[self.member]
        changed = self._changed()
        if changed:
            found = type(found)(**found.config() | changed)
        return found(space, budget, self.workers)


NO_AGENTS = ("popsize", None)
"""What ``agents`` left at None sets: nothing."""


def configuration(member: str) -> dict[str, Any]:
    """Return the settings of a configurable optimizer of the registry, none of one that is a class."""
    import nevergrad

    found: Any = nevergrad.optimizers.registry[member]
    return {} if isinstance(found, type) else dict(found.config())


def scalar(hint: Any) -> Any:
    """Return the part of a type hint that a parameter can have, None where that is nothing."""
    options = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    kept = tuple(option for option in options if option in SCALARS)
    return Union[kept] if set(kept) - {types.NoneType} else None  # noqa: UP007 - made at run time


@contextmanager
def in_step() -> Iterator[None]:
    """Have nevergrad's threads take turns with the caller, and end; mend what keeps its runs from being repeated.

    Nevergrad runs optimizers that want to call a function themselves in a thread, which goes on while the caller does:
    what each finds of the other's work depends on the machine. Here a value given to such a thread is followed by
    waiting for the thread's next point.
    """
    from unittest.mock import patch

    from cma.options_parameters import cma_default_options
    from nevergrad.optimization import callbacks, metamodel, optimizerlib, recaster

    before = set(threading.enumerate())
    es = optimizerlib._CMA.es.fget
    with (
        patch.object(recaster.MessagingThread, "messages_ask", property(lambda self: Turns(self._thread))),
        patch.object(recaster.MessagingThread, "messages_tell", property(lambda self: Turns(self._thread))),
        # its CmaFmin2 would be seeded by the clock; so it draws from numpy's global state
        patch.dict(cma_default_options, seed=np.nan),
        # in one dimension it writes into settings that all its later optimizers share
        patch.object(optimizerlib._CMA, "es", property(lambda self: es(own_settings(self)))),
        # its surrogates' searches, of a fixed number of evaluations, would end after 20 seconds of the clock
        patch.object(callbacks.EarlyStopping, "timer", staticmethod(lambda _: lambda _: None)),
        # they call float() of an array of one value, which numpy refuses since 2.4
        patch.object(metamodel, "float", lambda value: np.asarray(value).item(), create=True),
    ):
        try:
            yield
        finally:
            for thread in set(threading.enumerate()) - before:
                while isinstance(thread, recaster._MessagingThread) and thread.is_alive():
                    thread.stop()
                    thread.join(0.1)


class Turns:
    """The two queues of a thread of nevergrad: the points it asks about, and the values it is told."""

    def __init__(self, thread: Any) -> None:
        self.thread = thread
        self.asked, self.told = thread.messages_ask, thread.messages_tell

    def put(self, value: Any) -> None:
        """Tell the thread a value; returns when it has asked about its next point, or ended."""
        self.told.put(value)
        while self.thread.is_alive() and self.thread.call_count == self.told.unfinished_tasks:  # none is marked as done
            time.sleep(0)

    def get(self) -> Any:
        """Return the next point; raises RuntimeError where the thread waits for a value and would for ever."""
        waits = self.thread.is_alive() and self.asked.unfinished_tasks > self.told.unfinished_tasks
        if waits and self.asked.empty():
            raise RuntimeError("nevergrad asked twice for a point of an optimizer that takes one after the other")
        return self.asked.get()


def own_settings(optimizer: Any) -> Any:
    """Return the CMA-ES optimizer, with settings of its own in one dimension."""
    if optimizer.dimension == 1:
        optimizer._config = copy(optimizer._config)
    return optimizer


class Nevergrad(Family):
    """Nevergrad's registry, some hundred optimizers and their combinations, less what cannot run here."""

    name = "nevergrad"
    module = "nevergrad"
    extra = "nevergrad"

    def require(self) -> Any:
        """Return nevergrad; its import draws random numbers, which here are always the same and nobody else's."""
        with global_random_state(np.random.default_rng(0)), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return super().require()

    def members(self) -> list[str]:
        """Return the names of the registry that can run here."""
        registry = self.require().optimizers.registry
        wanted = set(registry) - EXCLUDED
        return [name for name in wanted if name.isidentifier() and not name.startswith(PREFIXES)]

    def derive(self, member: str) -> type[Optimizer]:
        """Return the optimizer class of one of them; its parameters are the settings that are scalars."""
        found: Any = self.require().optimizers.registry[member]
        settings = configuration(member)
        signature = inspect.signature(type(found).__init__).parameters if settings else {}
        hints = {key: scalar(signature[key].annotation) for key in settings}
        parameters: dict[str, tuple[Any, Any]] = {
            key: (hint, settings[key]) for key, hint in hints.items() if hint and isinstance(settings[key], SCALARS)
        }
        if "popsize" in parameters:
            size = parameters.pop("popsize")[1]
            parameters["agents"] = (int | None, parameter(size if isinstance(size, int) else None, minimum=4))
        return derive(
            NevergradOptimizer,
            f"{self.name}:{member}",
            parameters,
            self.load,
            member=member,
            mapped={key: "popsize" if key == "agents" else key for key in parameters},
            code=f"nevergrad {version('nevergrad')}",
            bibtex=LINEAGE.get(type(found).__name__, "") + LIBRARY,
            unmapped=UNMAPPED
            + tuple(
                f"the parameter {key!r} is no scalar and keeps nevergrad's value"
                for key in settings
                if key not in parameters and key != "popsize"
            ),
            __doc__=about(member, found),
        )


def about(member: str, found: Any) -> str:
    """Return one line on an optimizer of the registry: its own, or what it is a configuration of."""
    if isinstance(found, type):
        own = (found.__doc__ or "").strip().splitlines()
        return own[0] if own else f"Nevergrad's {member}, derived from its {found.__bases__[0].__name__}."
    defaults = {key: each.default for key, each in inspect.signature(type(found).__init__).parameters.items()}
    settings = ", ".join(f"{key}={value!r}" for key, value in found.config().items() if value != defaults[key])
    return f"Nevergrad's {type(found).__name__}({settings})."


nevergrad = Nevergrad()
