"""Take an object of a session to other processes by cloudpickle, and compare it by its whole pickled content.

A function or a class that another process can import travels by its name, and all else by its value: what stands in a
notebook, in ``__main__`` or within a function, with the global names and enclosing variables that its code reads.
"""

from __future__ import annotations

import copyreg
import dataclasses
import inspect
import io
import marshal
import pickle
import sys
from collections.abc import Iterable
from contextlib import suppress
from copy import copy
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple, Self, get_type_hints

import cloudpickle
from cloudpickle import cloudpickle as internals

from bench.contract.optimizer import Optimizer
from bench.contract.problem import Problem
from bench.helpers.errors import BenchError, explained
from bench.helpers.text import short_hash
from bench.plugins import observing
from bench.plugins.from_file import from_source
from bench.plugins.registry import is_installed

_MARKERS = {getattr(dataclasses, name): name for name in ("MISSING", "_HAS_DEFAULT_FACTORY")}
for _marker in _MARKERS:  # which dataclasses know by what they are: a copy would be another one
    copyreg.pickle(type(_marker), _MARKERS.__getitem__)

_PLAIN = (bool, int, float, str, type(None))


class PackedObject(NamedTuple):
    """An object as it travels.

    Attributes:
        content: what :func:`unpack` takes.
        digest: a hash of it without file names, lines and the numbers that cloudpickle gives to classes.
        source: the text of a Python file in its place, which is run where it is loaded.
    """

    content: bytes
    digest: str
    source: str | None = None


def pack(thing: object) -> PackedObject:
    """Return an object as it travels; raises BenchError where it cannot."""
    try:
        found = _Comparing.of(thing)
        annotated = [(kind, _annotations(kind)) for kind in found.classes]
        content = _Pickler.of((thing, annotated, _settings(found.modules))).content
    except Exception as error:  # as of a lock or an open file
        raise BenchError(
            f"{getattr(thing, '__name__', type(thing).__name__)!r} cannot be sent to other processes "
            f"({type(error).__name__}: {error}); have it make what it holds where it runs"
        ) from error
    compared = found.content
    for number in getattr(internals, "_DYNAMIC_CLASS_TRACKER_BY_CLASS", {}).values():  # drawn anew in each session
        compared = compared.replace(str(number).encode(), b"")
    return PackedObject(content, short_hash(compared))


def unpack(content: bytes) -> Any:
    """Return a copy of the object that :func:`pack` packed; raises what pickle raises.

    Raises:
        BenchError: where a module that it imports was changed in the session that packed it.
    """
    thing, annotations, settings = pickle.loads(content)
    for kind, types in annotations:
        # annotations in the form of strings are looked up in the class's module, which this process does not have
        kind.__annotations__ = types
    for name, values in settings.items():
        there = vars(sys.modules[name]) if name in sys.modules else values
        for key, value in values.items():
            if key in there and type(there[key]) in _PLAIN and repr(there[key]) != repr(value):
                raise BenchError(
                    f"{name}.{key} is {value!r} in this session, but {there[key]!r} in its file, which trials import: "
                    "make it a parameter, or write it into the file"
                )
    return thing


Objects = dict[str, PackedObject]
"""Objects by kind and name, such as ``"optimizers python:MyDE"``."""

held: Objects = {}
"""The objects that this process can load."""

given: dict[str, object] = {}
"""Those of them that were given in this process: to load a copy would write to their classes."""


def load(kind: str, name: str) -> Any:
    """Return the object that is held by that name; an instance is a copy of its own.

    Raises:
        BenchError: where this session holds none, or none that can be loaded in this process.
    """
    key = f"{kind} {name}"
    if key not in held:
        raise BenchError(
            f"{name!r} stands for an object of a Python session, and no file holds it: give the same object again, as "
            "to bench.compare with the folder as its output"
        )
    observing.note("objects", key, held[key].digest)
    if key in given:
        return copy(given[key]) if isinstance(given[key], (Problem, Optimizer)) else given[key]
    with explained(f"{name!r} cannot be loaded here", Exception):  # it may miss a module
        content, _, source = held[key]
        return unpack(content) if source is None else from_source(source)


class _Pickler(cloudpickle.Pickler):  # type: ignore[misc]
    """Pickles by value what no other process finds by its name.

    Attributes:
        content: what was pickled.
        classes: those that travel by value.
        modules: those that are imported by name, and belong to no installed package.
    """

    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, protocol=pickle.HIGHEST_PROTOCOL)
        self.content, self.classes, self.modules = b"", dict[type, None](), dict[str, None]()
        self._strange = list[ModuleType]()

    @classmethod
    def of(cls, thing: object) -> Self:
        """Return a pickler that has pickled an object."""
        file = io.BytesIO()
        pickler = cls(file)
        try:
            pickler.dump(thing)
        finally:
            for module in pickler._strange:
                cloudpickle.unregister_pickle_by_value(module)
        pickler.content = file.getvalue()
        return pickler

    def reducer_override(self, obj: object) -> Any:
        """Have a class or a function of a module that is known here alone travel by value."""
        if isinstance(obj, ModuleType) and _is_found(obj.__name__):
            self.modules.setdefault(obj.__name__)
        if isinstance(obj, type | FunctionType) and isinstance(name := getattr(obj, "__module__", None), str):
            module = sys.modules.get(name)
            if "<" not in obj.__qualname__ and _is_found(name):
                self.modules.setdefault(name)
            elif isinstance(obj, type):
                self.classes.setdefault(obj)
            if module and module not in self._strange and name != "__main__" and not _is_found(name):
                cloudpickle.register_pickle_by_value(module)
                self._strange.append(module)
        return super().reducer_override(obj)


class _Comparing(_Pickler):
    """Pickles code without the name and the lines of its file, which differ from session to session."""

    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, CodeType):
            return marshal.loads, (marshal.dumps(_bare(obj), 2),)
        if isinstance(inner := getattr(obj, "py_func", None), FunctionType):  # numba's, which has a number of its own
            return tuple, ((type(obj).__qualname__, inner),)
        reduced = super().reducer_override(obj)
        if isinstance(obj, type) and isinstance(reduced, tuple) and len(reduced) > 2:
            for name in ("__firstlineno__", "__static_attributes__"):  # of Python 3.13: lines, and names in any order
                reduced[2][0].pop(name, None)
        return reduced


def _bare(code: CodeType) -> CodeType:
    inner = tuple(_bare(each) if isinstance(each, CodeType) else _ordered(each) for each in code.co_consts)
    return code.replace(co_filename="", co_firstlineno=1, co_linetable=b"", co_consts=inner)


def _ordered(constant: object) -> object:
    return tuple(sorted(constant, key=repr)) if isinstance(constant, frozenset) else constant


def _annotations(kind: type) -> dict[str, object]:
    """Return the class's own annotations as types; unchanged where one of them cannot be evaluated."""
    annotations = inspect.get_annotations(kind)
    try:
        hints = get_type_hints(kind)
    except Exception:  # whoever checks the parameters reports it
        return annotations
    return {name: hints[name] for name in annotations if "ClassVar" not in str(annotations[name])}


def _settings(modules: Iterable[str]) -> dict[str, dict[str, object]]:
    """Return the plain public values of the modules that trials import anew, by their names."""
    found = {}
    for name in modules:
        file = str(getattr(sys.modules[name], "__file__", None) or "")
        if file and not is_installed(Path(file)) and name.partition(".")[0] not in {"bench", *sys.stdlib_module_names}:
            values = vars(sys.modules[name]).items()
            found[name] = {key: value for key, value in values if type(value) in _PLAIN and not key.startswith("_")}
    return found


@cache
def _is_found(name: str) -> bool:
    """Return whether a new process finds a module where this one did; ``__main__`` is another there."""
    module, above = sys.modules.get(name), name.rpartition(".")[0]
    if module is None or name == "__main__" or (above and not _is_found(above)):
        return False
    path = getattr(sys.modules.get(above), "__path__", None)
    finders = (finder.find_spec for finder in sys.meta_path if hasattr(finder, "find_spec"))
    spec = None
    with suppress(ImportError, ValueError):
        spec = next(filter(None, (find(name, path) for find in finders)), None)
    return spec is not None and spec.origin in ("built-in", "frozen", getattr(module, "__file__", None))
