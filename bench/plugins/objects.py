"""Take objects of a Python session as plug-ins: functions, classes and instances, by names such as ``python:MyDE``.

Whoever gives an object holds it under its name, packed as it then was, and every process of a run is sent what the
study names. No file holds it, so that in another session the same object has to be given again.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable
from typing import NamedTuple

from bench.contract.numbers import is_finite
from bench.contract.optimizer import Optimizer, defaults, settings
from bench.helpers.text import free, option, short_hash
from bench.plugins import packing, registry
from bench.plugins.loading import OBJECT, as_optimizer, as_problem, title
from bench.plugins.packing import Objects, PackedObject, pack

NAMELESS = ("function", "lambda")
"""What all functions without a name of their own are called, so that they are numbered."""


def among(optimizers: Iterable[str], problems: Iterable[str]) -> Objects:
    """Return the objects that these names stand for, as far as they are held here."""
    keys = [*map("optimizers {}".format, optimizers), *map("problems {}".format, problems)]
    return {key: packing.held[key] for key in keys if key in packing.held}


class Named(NamedTuple):
    """An object by name: the name that loads it, its label and its options."""

    name: str
    label: str
    options: dict[str, object]


def hold(kind: str, thing: object, label: str | None = None, taken: Collection[str] = ()) -> Named:
    """Hold an object as a plug-in; return how a study names it.

    An installed optimizer is named as such and not held. Where a study's file can hold what was chosen of an optimizer,
    that goes into the options and, in brackets, into the label.

    Args:
        kind: "optimizers" or "problems".
        thing: what :func:`~bench.plugins.loading.as_optimizer` or ``as_problem`` takes.
        label: what it is to be called; by default the name of its class or function, or the problem's.
        taken: the names of the objects held before that must stay; another one's is numbered.

    Raises:
        BenchError: for anything else, and for what cannot be sent to other processes.
    """
    own, chosen = label or title(thing), dict[str, object]()
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
    packed, base = pack(thing), OBJECT + (label or title(thing))
    digests = {name: packing.held[f"{kind} {name}"].digest for name in taken}
    name = free(base, {name for name, digest in digests.items() if digest != packed.digest})
    if twin := next((other for other, digest in digests.items() if other != name and digest == packed.digest), ""):
        warnings.warn(f"{name} has the same code and data as {twin}: a loop may give both its last value", stacklevel=3)
    packing.held[f"{kind} {name}"], packing.given[f"{kind} {name}"] = packed, thing
    return Named(name, own + name.removeprefix(base) if own in NAMELESS else own, chosen)


def packed(candidate: object) -> PackedObject:
    """Return a source, or what ``as_optimizer`` takes, as it travels; raises BenchError for anything else."""
    if isinstance(candidate, str):
        return PackedObject(b"", short_hash(candidate), candidate)
    made = as_optimizer(candidate)
    return pack(made if isinstance(candidate, Optimizer) else candidate)


def _installed(kind: type[Optimizer]) -> str:
    """Return the name that loads a class of optimizers anywhere, "" where there is none."""
    if name := str(vars(kind).get("plugin", "")):  # of a class that is made when it is loaded
        return name
    where = f"{kind.__module__}:{kind.__qualname__}"
    return next((name for name, entry in registry.entries("optimizers").items() if entry.value == where), "")
