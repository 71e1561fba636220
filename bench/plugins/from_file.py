"""Load optimizers and problems from a Python file that is not installed, as ``path/to/file.py:ClassName``."""

from __future__ import annotations

import ast
import hashlib
import inspect
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, ClassVar

import numpy as np

from bench.errors import BenchError, nearest
from bench.families import derive
from bench.helpers.text import listed
from bench.objective import Objective
from bench.optimizer import Optimizer, build, is_frozen, settings
from bench.problem import Problem

Files = dict[Path, bytes]
"""The content of files of plug-ins, by the path under which a study names them."""


def split(name: str) -> tuple[Path, str] | None:
    """Return file and attribute of a name such as ``"my/file.py:Mine"``, or None for a name of another form."""
    path, colon, attribute = name.rpartition(":")
    return (Path(path), attribute) if colon and path.endswith(".py") else None


def require_class(name: str, kind: str = "optimizer") -> None:
    """Raise BenchError for the name of a Python file without a class behind it, naming those in it; it is not run."""
    if not name.endswith(".py"):
        return
    code = _content(Path(name), kind)
    try:
        parts = ast.parse(code).body
    except (SyntaxError, ValueError) as error:  # ValueError: a NUL byte
        raise BenchError(f"the {kind} file {name} cannot be read as Python: {error}") from error
    kinds = (ast.ClassDef, ast.FunctionDef)
    names = [part.name for part in parts if isinstance(part, kinds) and not part.name.startswith("_")]
    holds = f"; it holds {listed(names)}" if names else ""
    raise BenchError(
        f"{name!r} names a file alone; add the class or function: {name}:{(names or ['ClassName'])[0]}{holds}"
    )


def load_optimizer(name: str, /, **options: Any) -> Optimizer:
    """Return the optimizer of that file with these parameters; a plain function becomes one.

    Raises:
        BenchError: where the file is missing or fails to run, or holds no such class or function, and for options that
            are no parameters or out of range.
    """
    path, _, attribute = name.rpartition(":")
    return build(_optimizer(name, attribute, Path(path).resolve(), _content(Path(path), "optimizer")), name, options)


def load_problem(name: str, /, **options: Any) -> Problem:
    """Return the problem of that file: an instance, or what a class or a function makes of these options.

    Unless the problem has a fingerprint of its own, it is that of the file.

    Raises:
        BenchError: where the file is missing or fails to run, or holds no such problem, or the options do not suit it.
    """
    file, _, attribute = name.rpartition(":")
    path = Path(file)
    content = _content(path, "problem")
    module = _module(path.resolve(), content, "problem")
    if attribute not in vars(module):
        names = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]
        raise BenchError(f"{path} holds no problem called {attribute!r}{nearest(attribute, names)}")
    problem = vars(module)[attribute]
    if callable(problem) and not isinstance(problem, Problem):
        try:
            problem = problem(**options)
        except Exception as error:  # the file may raise anything
            raise BenchError(f"{name!r} cannot be made: {type(error).__name__}: {error}") from error
    if not isinstance(problem, Problem):
        raise BenchError(f"{attribute!r} of {path} is neither a Problem nor a class or function that makes one")
    if not problem.fingerprint():
        object.__setattr__(problem, "fingerprint", partial(str, _digest(content)))  # also of a frozen dataclass
    return problem


def contents(names: Iterable[str], kind: str = "optimizer") -> Files:
    """Return the files that such names name, by path; raises BenchError where one cannot be read."""
    return {parts[0]: _content(parts[0], kind) for name in names if (parts := split(name))}


def take(files: Files) -> None:
    """Have this process load these files with this content, whatever stands on its disk by then."""
    _taken.update(files)


def changed(files: Files) -> list[str]:
    """Return the paths of files whose content on the disk is another one, or that are no longer there."""
    different = []
    for path, content in files.items():
        with suppress(OSError):
            if path.read_bytes() == content:
                continue
        different.append(str(path))
    return different


def fingerprint(name: str, files: Files) -> str:
    """Return a hash of the file of such a name, whose code is not run."""
    return _digest(files[Path(name.rpartition(":")[0])])


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _content(path: Path, kind: str) -> bytes:
    if path in _taken:
        return _taken[path]
    try:
        return path.read_bytes()
    except OSError as error:
        raise BenchError(f"the {kind} file {path} cannot be read: {error.strerror}") from error


_taken: Files = {}


@cache
def _optimizer(name: str, attribute: str, path: Path, content: bytes) -> type[Optimizer]:
    module, fingerprint = _module(path, content), _digest(content)
    plugin = vars(module).get(attribute)
    if isinstance(plugin, type) and issubclass(plugin, Optimizer):
        if not is_frozen(plugin):
            return plugin  # build() refuses it
        return derive(plugin, name, {}, load_optimizer, __doc__=plugin.__doc__, fingerprint=fingerprint)
    if inspect.isfunction(plugin):
        return _of_function(plugin, name, fingerprint)
    if attribute in vars(module):
        raise BenchError(f"{attribute!r} of {path} is neither an Optimizer subclass nor a function")
    names = [key for key, value in vars(module).items() if _is_own_optimizer(module, value)]
    raise BenchError(f"{path} holds no optimizer called {attribute!r}{nearest(attribute, names)}")


class _ContentLoader(SourceFileLoader):
    """Compiles a file's content as it was read: the file may have changed since, and cached bytecode before."""

    def __init__(self, name: str, path: Path, content: bytes) -> None:
        super().__init__(name, str(path))
        self._content = content

    def get_data(self, path: str) -> bytes:
        return self._content if path == self.path else super().get_data(path)

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002 - a loader's signature
        return self.source_to_code(self._content, self.path)


@cache
def _module(path: Path, content: bytes, kind: str = "optimizer") -> ModuleType:
    """Import the file as a module of its own, which can import the modules beside it."""
    name = f"bench_file_{path.stem}_{_digest(content)}"  # an edited file is another module
    spec = spec_from_file_location(name, path, loader=_ContentLoader(name, path, content))
    if spec is None or spec.loader is None:
        raise BenchError(f"the {kind} file {path} cannot be read as Python")
    module = module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look up annotations there
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # the file may raise anything
        del sys.modules[name]
        raise BenchError(f"the {kind} file {path} failed to load: {type(error).__name__}: {error}") from error
    return module


def _is_own_optimizer(module: ModuleType, value: object) -> bool:
    is_own = getattr(value, "__module__", None) == module.__name__
    return is_own and (inspect.isfunction(value) or (isinstance(value, type) and issubclass(value, Optimizer)))


@dataclass(frozen=True)
class _FunctionOptimizer(Optimizer):
    """A plain function ``minimize(objective, rng, …)`` as an optimizer."""

    function: ClassVar[Callable[..., None]]

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Call the function with the parameters as keywords."""
        type(self).function(objective, rng, **settings(self))


def _of_function(function: Callable[..., Any], name: str, fingerprint: str) -> type[Optimizer]:
    """Return the optimizer class of a function; its arguments after ``objective`` and ``rng`` become parameters."""
    try:
        taken = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):  # a decorator may leave a signature that cannot be read
        taken = []
    keywords, plain = taken[2:], (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if len(taken) < 2 or any(argument.kind not in plain for argument in taken[:2]):
        raise BenchError(f"{name!r} must take (objective, rng) first, as in def minimize(objective, rng, step=0.1)")
    for argument in keywords:
        if argument.default is argument.empty or argument.kind is inspect.Parameter.POSITIONAL_ONLY:
            raise BenchError(f"parameter {argument.name!r} of {name!r} must be a keyword with a default")
    kinds = {bool: bool, int: int, float: float, str: str}
    parameters = {argument.name: (kinds.get(type(argument.default), Any), argument.default) for argument in keywords}
    doc = inspect.getdoc(function) or f"The function {name}."
    attributes = {"function": staticmethod(function), "__doc__": doc, "fingerprint": fingerprint}
    return derive(_FunctionOptimizer, name, parameters, load_optimizer, **attributes)
