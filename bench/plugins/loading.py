"""Load an optimizer or a problem: an installed one by name, a member of a family, a class in a file, or an object."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from typing import Any

from bench.contract.families import derive
from bench.contract.optimizer import Optimizer, build, is_frozen, settings
from bench.contract.problem import FunctionProblem, Problem, with_own_box
from bench.helpers.errors import BenchError, explained, nearest
from bench.plugins import from_file, packing, registry
from bench.plugins.functions import class_of

IMPORTED = "imported"
"""The family of names that only imported results have, such as ``imported:DIRECT``: nothing can be loaded for them."""

OBJECT = "python:"
"""The prefix of names of objects of a session."""

OptimizerLike = str | Optimizer | type | Callable[..., object]
"""What may stand for an optimizer: see :func:`as_optimizer`."""

ProblemLike = str | Problem | type[Problem]
"""What may stand for a problem of a study."""

_ANY = (Exception, SystemExit)  # what a plug-in's package may raise


def is_imported(name: str) -> bool:
    """Return whether a problem's or an optimizer's name is that of imported results."""
    return name.startswith(f"{IMPORTED}:")


def brings_code(name: str) -> bool:
    """Return whether a name stands for code that is not installed: that of a file, or a program to start."""
    return from_file.split(name) is not None or name.startswith("command:")


def is_plugin(thing: object) -> bool:
    """Return whether something in the place of a name may be a problem or an optimizer itself."""
    return callable(thing) or isinstance(thing, (Problem, Optimizer))


def is_object(name: str) -> bool:
    """Return whether a name stands for an object of a session."""
    return name.startswith(OBJECT)


def default_label(name: str) -> str:
    """Return the default label of a plug-in name: the class's for one of a file or of a session, else the name."""
    parts = from_file.split(name)
    return parts[1] if parts and parts[1] else name.removeprefix(OBJECT)


def title(thing: object) -> str:
    """Return the title of a plug-in: its name, or that of a problem, of a class or of a function."""
    if isinstance(thing, (str, Problem)):
        return thing if isinstance(thing, str) else str(thing.name)
    function = getattr(thing, "func", thing)  # of a functools.partial
    name = str(getattr(function, "__name__", type(function).__name__))
    return "lambda" if name == "<lambda>" else name


# optimizers


def load_optimizer(name: str, /, **options: object) -> Optimizer:
    """Return the optimizer of that name, such as ``load_optimizer("gwo", agents=300)``.

    Args:
        name: an installed optimizer, a member of a family (``"mealpy:OriginalGWO"``), or a class or function of a file
            (``"path/to/file.py:ClassName"``).
        options: its parameters.

    Raises:
        BenchError: for an unknown name or parameter (naming the nearest) or a value out of range.
    """
    if is_imported(name):
        raise BenchError(f"{name!r} stands for imported results, whose optimizer is not here; it cannot be run")
    if from_file.split(name):
        return build(_class_in_file(name, from_file.content(name)), name, options)
    if is_object(name):
        return as_optimizer(packing.load("optimizers", name), name, options)
    family, colon, _ = name.partition(":")
    installed = registry.entries("optimizers")
    entry = name if name in installed else family
    if entry not in installed:
        from_file.require_class(name)
        known = f"; known: {', '.join(sorted(installed))}"
        raise BenchError(f"unknown optimizer {name!r}{nearest(name, list_optimizers(), known)}")
    plugin = registry.load("optimizers", entry)
    if isinstance(plugin, type) and issubclass(plugin, Optimizer) and not colon:
        return build(plugin, name, options)
    if registry.is_family(plugin) and colon:
        plugin = _call_loader(plugin.load, name, options)
    if isinstance(plugin, Optimizer):
        return plugin
    raise BenchError(f"{name!r} is no Optimizer subclass, nor a family's member: name one as '{family}:<name>'")


@cache
def _class_in_file(name: str, content: bytes) -> type[Optimizer]:
    plugin = class_of(from_file.attribute(name, content, "optimizer"), name, load_optimizer)
    if "plugin" in vars(plugin) or not is_frozen(plugin):  # build() refuses the latter
        return plugin
    return derive(plugin, name, {}, load_optimizer, __doc__=plugin.__doc__)


def as_optimizer(thing: object, name: str = "", options: Mapping[str, object] | None = None) -> Optimizer:
    """Return the optimizer that a name stands for, that an object is, or that a class or a function makes.

    Args:
        thing: a name; an optimizer; a class of optimizers; a function ``(objective, rng, …)``; a class
            ``(objective, rng, …)`` whose instances ask and tell; or a class ``(budget, dim, …)`` whose instances are
            called with the function. What these take further, with defaults, are parameters.
        name: in messages, and the name that loads it in another process; by default what it is called.
        options: parameters; of an optimizer, other ones than its own.

    Raises:
        BenchError: for anything else, and for parameters that it does not have.
    """
    name, chosen = name or title(thing), dict(options or {})
    if isinstance(thing, str):
        return load_optimizer(thing, **chosen)
    if not isinstance(thing, Optimizer):
        return build(class_of(thing, name, load_optimizer), name, chosen)
    if not is_frozen(type(thing)):
        raise BenchError(
            f"the class of {name!r} must be a frozen dataclass: write @dataclass(frozen=True) above it, and each "
            "parameter as a field"
        )
    return build(type(thing), name, settings(thing) | chosen) if chosen else thing


def list_optimizers(pattern: str = "*") -> list[str]:
    """Return the names of the optimizers that match a pattern such as ``"mealpy:*GWO"``; by default all.

    Members of families are among them where their libraries are installed.
    """
    return fnmatch.filter(_names("optimizers"), pattern)


def _names(group: str) -> list[str]:
    names: list[str] = []
    for entry in sorted(registry.entries(group)):
        with suppress(*_ANY):  # a library that is missing or broken must not hide the others
            plugin = registry.load(group, entry)
            names += plugin.names() if registry.is_family(plugin) else [entry]
    return names


def matching(pattern: str) -> list[str]:
    """Return the members of a family that match a pattern such as ``"mealpy:*GWO"``, or the name if it is no pattern.

    Raises:
        BenchError: where no member matches, or the family's library is missing.
    """
    family, colon, member = pattern.partition(":")
    if not (colon and "*" in member) or from_file.split(pattern) or family not in registry.entries("optimizers"):
        return [pattern]
    names: list[str] = fnmatch.filter(registry.load("optimizers", family).names(), pattern)
    if not names:
        raise BenchError(f"no optimizer matches {pattern!r}; 'bench list {family}' shows all")
    return names


def package(optimizer: str) -> str:
    """Return the file, object, family or module that an optimizer's name points to, without loading it."""
    if parts := from_file.split(optimizer):
        return str(parts[0])
    prefix, colon, _ = optimizer.partition(":")
    installed = registry.entries("optimizers").get(optimizer)
    if is_object(optimizer):
        return optimizer
    return prefix if colon or installed is None else installed.module


def is_built_in(optimizer: str) -> bool:
    """Return whether an optimizer's code, if not the library behind it, comes with the harness; nothing is loaded."""
    entry = None if from_file.split(optimizer) else registry.entry("optimizers", optimizer)
    return entry is not None and entry.dist is not None and entry.dist.name == registry.DISTRIBUTION


# problems


def load_problem(name: str, /, **options: object) -> Problem:
    """Return the problem of that name, such as ``load_problem("signature-12", unit="rpm")``.

    A name may also be that of a file's problem, or of its class or function that makes one: ``"my/file.py:Mine"``.

    Raises:
        BenchError: for an unknown name or option (naming the nearest), data that cannot be read, and bounds that are
            no box.
    """
    if is_imported(name):
        raise BenchError(f"{name!r} is known from imported results only: no installed family has it")
    if from_file.split(name):
        made = from_file.attribute(name, from_file.content(name), "problem")
        is_one = isinstance(made, Problem) or not callable(made)
        return _problem(made if is_one else _call_loader(made, name, options), name)
    if is_object(name):
        return as_problem(packing.load("problems", name), options=options)
    families = registry.entries("problems")
    for known in sorted(families, key=lambda each: each != family(name)):
        own, found = name.startswith(known), False  # a broken family must not block another's problem
        with explained(f"problem {name!r} cannot be looked up", _ANY) if own else suppress(*_ANY):
            plugin = registry.load("problems", known)
            is_suite = hasattr(plugin, "grid") and f"{name}-".startswith(f"{known}-")  # it loads more than it lists
            found = is_suite or name.startswith(f"{known}:") or name in plugin.names()
        if found:
            return _problem(_call_loader(plugin.load, name, options), name)
    from_file.require_class(name)
    otherwise = f"; the families are {', '.join(sorted(families))}: 'bench list problems' shows them"
    raise BenchError(f"unknown problem {name!r}{nearest(name, _names('problems'), otherwise)}")


def as_problem(
    thing: object, bounds: Sequence[tuple[float, float]] | None = None, options: Mapping[str, object] | None = None
) -> Problem:
    """Return a problem: of a name, the object itself, an instance of the class, or the function with its bounds.

    Raises:
        BenchError: for anything else, for bounds that are not a box, and for options that a class does not take.
    """
    thing = load_problem(thing) if isinstance(thing, str) else thing
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


def family(problem: str) -> str:
    """Return the family that a problem's name points to, without loading it; the name itself where none is known."""
    prefix, colon, _ = problem.partition(":")
    families = registry.entries("problems")
    if colon and prefix in families:
        return prefix
    return max(filter(problem.startswith, families), key=len, default=problem)


def is_problem(name: str) -> bool:
    """Return whether a name is a problem's, or that of a family of problems, by its form; nothing is loaded.

    Raises:
        BenchError: where it names a file that is missing or no Python.
    """
    if from_file.split(name):
        return from_file.is_problem(name)
    return registry.entry("optimizers", name) is None and family(name) in registry.entries("problems")


def _problem(loaded: object, name: str) -> Problem:
    if isinstance(loaded, Problem):
        return with_own_box(loaded)
    raise BenchError(f"the plug-in behind {name!r} did not return a Problem but a {type(loaded).__name__}")


# both


def _call_loader(loader: Callable[..., Any], name: str, options: Mapping[str, object]) -> Any:
    """Call what makes a plug-in; turn any exception into a BenchError of one sentence."""
    with explained(f"{name!r} cannot be loaded", _ANY):
        return loader(**options) if from_file.split(name) else loader(name, **options)
