"""Take an object of a session to other processes by its value, and hash the code and the data that it is made of.

A function or a class that another process can import travels by its name, and all else by its value: what stands in a
notebook, in ``__main__`` or within a function, with the global names and enclosing variables that its code reads.
"""

from __future__ import annotations

import copyreg
import dataclasses
import dis
import inspect
import pickle
import sys
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from functools import cache
from itertools import accumulate
from types import CodeType, FunctionType, GetSetDescriptorType, MappingProxyType, MemberDescriptorType, ModuleType
from typing import Any, NamedTuple, get_type_hints

import cloudpickle
from joblib.hashing import NumpyHasher

from bench.errors import BenchError
from bench.helpers.text import short_hash


def _name_of(marker: object) -> str:
    return next(name for name in _MARKERS if getattr(dataclasses, name) is marker)


_MARKERS = "MISSING", "_HAS_DEFAULT_FACTORY"  # which dataclasses know by what they are: a copy would be another one
for _marker in _MARKERS:
    copyreg.pickle(type(getattr(dataclasses, _marker)), _name_of)


class PackedObject(NamedTuple):
    """An object as it travels.

    Attributes:
        content: what :func:`unpack` takes.
        digest: a hash of the bytecode and the data; of the content where it holds what has no hash of its value, which
            may then be another one each time.
        modules: the modules that it imports by name.
    """

    content: bytes
    digest: str
    modules: tuple[str, ...]


def pack(thing: object) -> PackedObject:
    """Return an object as it travels; raises BenchError where it cannot."""
    hasher = _Hasher()
    digest = ""
    with suppress(Exception):  # the object may hold anything; then its content is hashed
        digest = hasher.hash(thing)
    strange = hasher.strange & sys.modules.keys() - {"__main__"}  # cloudpickle takes all of these by name otherwise
    try:
        with ExitStack() as stack:
            for module in map(sys.modules.__getitem__, strange):
                cloudpickle.register_pickle_by_value(module)
                stack.callback(cloudpickle.unregister_pickle_by_value, module)
            content = cloudpickle.dumps((thing, [(kind, _annotations(kind)) for kind in hasher.classes]))
    except Exception as error:  # as of a lock or an open file
        raise BenchError(
            f"{getattr(thing, '__name__', type(thing).__name__)!r} cannot be sent to other processes "
            f"({type(error).__name__}: {error}); have it make what it holds where it runs"
        ) from error
    return PackedObject(content, digest or short_hash(content), tuple(sorted(hasher.modules)))


def unpack(content: bytes) -> Any:
    """Return a copy of the object that :func:`pack` packed; raises what pickle raises."""
    thing, annotations = pickle.loads(content)
    for kind, types in annotations:
        # annotations in the form of strings are looked up in the class's module, which this process does not have
        kind.__annotations__ = types
    return thing


def _annotations(kind: type) -> dict[str, Any]:
    """Return the class's own annotations as types; unchanged where one of them cannot be evaluated."""
    annotations = inspect.get_annotations(kind)
    try:
        hints = get_type_hints(kind)
    except Exception:  # whoever checks the parameters reports it
        return annotations
    return {name: hints[name] for name in annotations if "ClassVar" not in str(annotations[name])}


def importable(thing: type | FunctionType) -> bool:
    """Return whether a new process finds a class or a function where this one did; ``__main__`` is another there."""
    return "<" not in thing.__qualname__ and _found(thing.__module__)  # <locals>, <lambda>


@cache
def _found(module_name: str) -> bool:
    module = sys.modules.get(module_name)
    if module is None or module_name == "__main__":
        return False
    spec, path = None, None
    for name in accumulate(module_name.split("."), "{}.{}".format):
        spec = next(filter(None, (finder.find_spec(name, path) for finder in sys.meta_path)), None)
        if spec is None:
            return False
        path = spec.submodule_search_locations
    return spec is not None and spec.origin in ("built-in", "frozen", getattr(module, "__file__", None))


_NO_CODE = {
    "__dict__", "__doc__", "__firstlineno__", "__module__", "__slotnames__", "__static_attributes__", "__weakref__",
    "_abc_impl",
}  # fmt: skip


class _Hasher(NumpyHasher):  # type: ignore[misc]
    """Hashes what joblib hashes, and beside it functions and classes that travel by value: by their bytecode.

    Attributes:
        classes: those that travel by value, as they are found.
        strange: the modules of what travels by value, by name, of which one may be known here alone.
        modules: the modules of all else, by name.
    """

    def __init__(self) -> None:
        super().__init__(hash_name="sha256")
        self.classes: dict[type, None] = {}
        self.strange: set[str] = set()
        self.modules: set[str] = set()

    def hash(self, thing: object) -> str:
        return str(super().hash(thing))[:16]

    def memoize(self, thing: object) -> None:
        """Remember only what may hold itself: whether two equal constants are one object is an accident."""
        if not isinstance(thing, (tuple, frozenset, int, float, complex)):
            super().memoize(thing)

    def reducer_override(self, thing: Any) -> Any:
        """Return the form of an object in the hash, as a pickler takes it; its state comes last, after itself."""
        match thing:
            case type() if thing is str:  # which all that stand for others are made of
                return NotImplemented
            case CodeType():
                return _standing("code", _of_code(thing))
            case FunctionType() if not importable(thing):
                self.strange.add(thing.__module__)
                return _standing("function", _of_function(thing))
            case type() if not importable(thing):
                self.classes.setdefault(thing)
                self.strange.add(thing.__module__)
                return _standing("class", (thing.__bases__, _of_class(thing)))
            case FunctionType() | type():
                self.modules.add(thing.__module__)
                return _standing("name", (thing.__module__, thing.__qualname__))
            case ModuleType():
                self.modules.add(thing.__name__)
                return _standing("module", thing.__name__)
            case MappingProxyType():
                return _standing("mapping", dict(thing))
            case frozenset():
                return _standing("set", sorted(map(repr, thing)))
            case property():
                return _standing("property", (thing.fget, thing.fset))
            case staticmethod() | classmethod():
                return _standing(type(thing).__name__, thing.__func__)
            case _ if callable(thing):  # compiled by numba, or with a cache: neither is a function
                inner = getattr(thing, "py_func", None) or getattr(thing, "__wrapped__", None)
                if isinstance(inner, FunctionType):
                    return _standing(type(thing).__name__, inner)
        return NotImplemented


def _standing(kind: str, state: object) -> tuple[Any, ...]:
    return str, (kind,), {"": state}


def _of_code(code: CodeType) -> tuple[Any, ...]:
    arguments = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    return code.co_code, code.co_exceptiontable, code.co_consts, arguments, names


def _of_function(function: FunctionType) -> tuple[Any, ...]:
    closure = []
    for cell in function.__closure__ or ():
        with suppress(ValueError):  # an empty one
            closure.append(cell.cell_contents)
    read = sorted({*_globals(function.__code__)} & function.__globals__.keys())
    values = {name: function.__globals__[name] for name in read}
    return function.__code__, function.__defaults__, function.__kwdefaults__, closure, values


def _globals(code: CodeType) -> Iterator[str]:
    """Yield the global names that code reads, that of functions within it included."""
    yield from (str(each.argval) for each in dis.get_instructions(code) if each.opname in ("LOAD_GLOBAL", "LOAD_NAME"))
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _globals(inner)


def _of_class(kind: type) -> dict[str, Any]:
    """Return the attributes of a class, without those that follow from others, such as its slots."""
    made = (GetSetDescriptorType, MemberDescriptorType)
    return {name: value for name, value in vars(kind).items() if name not in _NO_CODE and not isinstance(value, made)}
