"""Take objects of a Python session as plug-ins: functions, classes and instances, by names such as ``python:MyDE``.

Whoever gives an object holds it here under its name, packed as it then was, and every process of a run is sent what the
study names. No file holds it, so that in another session the same object has to be given again.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from copy import copy
from typing import Any, NamedTuple

from bench.errors import BenchError, explained
from bench.helpers.text import free, option, short_hash
from bench.numbers import is_finite
from bench.optimizer import Optimizer, build, defaults, is_frozen, settings
from bench.plugins import observing, registry
from bench.plugins.from_file import from_source
from bench.plugins.functions import class_of
from bench.plugins.packing import PackedObject, pack, unpack
from bench.problem import FunctionProblem, Problem, with_own_box

PREFIX = "python:"
NAMELESS = ("function", "lambda")
"""What all functions without a name of their own are called, so that they are numbered."""

OptimizerLike = str | Optimizer | type | Callable[..., object]
"""What may stand for an optimizer: a name, or what :func:`as_optimizer` takes."""

ProblemLike = str | Problem | type[Problem]
"""What may stand for a problem of a study."""

Objects = dict[str, PackedObject]
"""Objects by kind and name, such as ``"optimizers python:MyDE"``."""

held: Objects = {}
"""The objects that this process can load."""

_own: dict[str, Any] = {}  # those that were given in this process: to load a copy would write to their classes


def is_object(name: str) -> bool:
    """Return whether a name stands for an object of a session."""
    return name.startswith(PREFIX)


def is_plugin(thing: object) -> bool:
    """Return whether something in the place of a name may be a problem or an optimizer itself."""
    return callable(thing) or isinstance(thing, (Problem, Optimizer))


def among(optimizers: Iterable[str], problems: Iterable[str]) -> Objects:
    """Return the objects that these names stand for, as far as they are held here."""
    keys = [*map("optimizers {}".format, optimizers), *map("problems {}".format, problems)]
    return {key: held[key] for key in keys if key in held}


class Named(NamedTuple):
    """An object by name: the name that loads it, its label and its options."""

    name: str
    label: str
    options: dict[str, Any]


def hold(kind: str, thing: Any, label: str | None = None, taken: Collection[str] = ()) -> Named:
    """Hold an object as a plug-in; return how a study names it.

    An installed optimizer is named as such and not held. Where a study's file can hold what was chosen of an optimizer,
    that goes into the options and, in brackets, into the label.

    Args:
        kind: "optimizers" or "problems".
        thing: what :func:`as_optimizer` or :func:`as_problem` takes.
        label: what it is to be called; by default the name of its class or function, or the problem's.
        taken: the names of the objects held before that must stay; another one's is numbered.

    Raises:
        BenchError: for anything else, and for what cannot be sent to other processes.
    """
    own, chosen = label or title(thing), dict[str, Any]()
    if kind == "problems":
        as_problem(thing)
    else:
        made = as_optimizer(thing, own)
        usual = defaults(made)
        differing = {key: value for key, value in settings(made).items() if key not in usual or value != usual[key]}
        is_own = isinstance(thing, Optimizer) or (isinstance(thing, type) and issubclass(thing, Optimizer))
        if is_own and all(isinstance(value, (bool, str)) or is_finite(value) for value in differing.values()):
            thing, chosen, installed = type(made), differing, _installed(type(made))
            shown = ",".join(f"{key}={option(value)}" for key, value in chosen.items())
            own = label or (installed or own) + (f"[{shown}]" if shown else "")
            if installed:
                return Named(installed, own, chosen)
    packed, base = pack(thing), PREFIX + (label or title(thing))
    digests = {name: held[f"{kind} {name}"].digest for name in taken}
    name = free(base, {name for name, digest in digests.items() if digest != packed.digest})
    if twin := next((other for other, digest in digests.items() if other != name and digest == packed.digest), ""):
        warnings.warn(f"{name} has the same code and data as {twin}: a loop may give both its last value", stacklevel=3)
    held[f"{kind} {name}"], _own[f"{kind} {name}"] = packed, thing
    return Named(name, own + name.removeprefix(base) if own in NAMELESS else own, chosen)


def packed(candidate: Any) -> PackedObject:
    """Return a source, or what :func:`as_optimizer` takes, as it travels; raises BenchError for anything else."""
    if isinstance(candidate, str):
        return PackedObject(b"", short_hash(candidate), candidate)
    made = as_optimizer(candidate)
    return pack(made if isinstance(candidate, Optimizer) else candidate)


def _load(kind: str, name: str) -> Any:
    """Return the object of that name; an instance is a copy of its own.

    Raises:
        BenchError: where this session holds none, or none that can be loaded in this process.
    """
    if (packed := held.get(f"{kind} {name}")) is None:
        raise BenchError(
            f"{name!r} stands for an object of a Python session, and no file holds it: give the same object again, as "
            "to bench.compare with the folder as its output"
        )
    observing.note("objects", f"{kind} {name}", packed.digest)
    if (own := _own.get(f"{kind} {name}")) is not None:
        return copy(own) if isinstance(own, (Problem, Optimizer)) else own
    with explained(f"{name!r} cannot be loaded here", Exception):  # it may miss a module
        return unpack(packed.content) if packed.source is None else from_source(packed.source)


def load_optimizer(name: str, /, **options: Any) -> Optimizer:
    """Return the optimizer of that name with these parameters; raises BenchError if the session does not hold it."""
    return as_optimizer(_load("optimizers", name), name, options)


def load_problem(name: str, /, **options: Any) -> Problem:
    """Return the problem of that name; raises BenchError likewise."""
    return as_problem(_load("problems", name), options=options)


def as_optimizer(thing: Any, name: str = "", options: Mapping[str, Any] | None = None) -> Optimizer:
    """Return the optimizer that an object is, or that a class or a function makes.

    Args:
        thing: an optimizer; a class of optimizers; a function ``(objective, rng, …)``; a class ``(objective, rng, …)``
            whose instances ask and tell; or a class ``(budget, dim, …)`` whose instances are called with the function.
            What these take further, with defaults, are parameters.
        name: in messages, and the name that loads it in another process; by default what it is called.
        options: parameters; of an optimizer, other ones than its own.

    Raises:
        BenchError: for anything else, and for parameters that it does not have.
    """
    name, chosen = name or title(thing), dict(options or {})
    if isinstance(thing, Optimizer):
        if not is_frozen(type(thing)):
            raise BenchError(
                f"the class of {name!r} must be a frozen dataclass: write @dataclass(frozen=True) above it, and each "
                "parameter as a field"
            )
        return build(type(thing), name, settings(thing) | chosen) if chosen else thing
    return build(class_of(thing, name, load_optimizer), name, chosen)


def as_problem(
    thing: Any, bounds: Sequence[tuple[float, float]] | None = None, options: Mapping[str, Any] | None = None
) -> Problem:
    """Return a problem: the object itself, an instance of the class, or the function with its bounds.

    Raises:
        BenchError: for anything else, for bounds that are no box, and for options that a class does not take.
    """
    if isinstance(thing, Problem):
        if bounds is not None or options:
            raise BenchError(f"the problem {thing.name!r} is made already; leave out its bounds and options")
        return with_own_box(thing)
    if isinstance(thing, type) and issubclass(thing, Problem):
        with explained(f"{title(thing)!r} cannot be made", Exception):  # its code may raise anything
            return as_problem(thing(**options or {}), bounds)
    if not callable(thing) or isinstance(thing, type):
        raise BenchError(f"{title(thing)!r} is no problem: give a name, a bench.Problem, or a function with bounds")
    if bounds is None:
        raise BenchError(
            f"the function {title(thing)!r} needs bounds to be a problem: bench.FunctionProblem({title(thing)}, lower, "
            "upper), or bounds=[(lower, upper), …] in bench.solve"
        )
    try:
        lower, upper = zip(*bounds, strict=True)
    except (TypeError, ValueError) as error:
        raise BenchError(f"bounds must be a pair (lower, upper) for each variable, not {bounds!r}") from error
    return FunctionProblem(thing, lower, upper, name=title(thing))


def title(thing: Any) -> str:
    """Return the title of an object: the name of a problem, of a class or of a function."""
    if isinstance(thing, Problem):
        return str(thing.name)
    function = getattr(thing, "func", thing)  # of a functools.partial
    name = str(getattr(function, "__name__", type(function).__name__))
    return "lambda" if name == "<lambda>" else name


def _installed(kind: type[Optimizer]) -> str:
    """Return the name that loads a class of optimizers anywhere, "" where there is none."""
    if name := str(vars(kind).get("plugin", "")):  # of a class that is made when it is loaded
        return name
    where = f"{kind.__module__}:{kind.__qualname__}"
    return next((name for name, entry in registry.entries("optimizers").items() if entry.value == where), "")
