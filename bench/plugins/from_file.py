"""Load optimizers and problems from a Python file that is not installed, as ``path/to/file.py:ClassName``."""

from __future__ import annotations

import ast
import inspect
import sys
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from bench.errors import BenchError, explained, nearest
from bench.families import derive
from bench.helpers.text import listed, short_hash
from bench.optimizer import Optimizer, build, is_frozen
from bench.plugins import observing
from bench.plugins.functions import is_loose, optimizer_of
from bench.problem import Problem


def split(name: str) -> tuple[Path, str] | None:
    """Return file and attribute of a name such as ``"my/file.py:Mine"``, or None for a name of another form."""
    path, colon, attribute = name.rpartition(":")
    return (Path(path), attribute) if colon and path.endswith(".py") else None


def require_class(name: str, kind: str = "optimizer") -> None:
    """Raise BenchError for the name of a Python file without a class behind it, naming those in it; it is not run."""
    if not name.endswith(".py"):
        return
    parts = _parsed(Path(name), kind)
    kinds = (ast.ClassDef, ast.FunctionDef)
    names = [part.name for part in parts if isinstance(part, kinds) and not part.name.startswith("_")]
    holds = f"; it holds {listed(names)}" if names else ""
    raise BenchError(
        f"{name!r} names a file alone; add the class or function: {name}:{(names or ['ClassName'])[0]}{holds}"
    )


def is_problem(name: str) -> bool:
    """Return whether the name of a file's class, function or object is a problem's, by its text; it is not run.

    A class is one where a base of it is called ``…Problem``, a function where it needs fewer than the two arguments of
    an optimizer's, ``(objective, rng)``, and any other object is.

    Raises:
        BenchError: where the file is missing or no Python.
    """
    path, _, attribute = name.rpartition(":")
    parts = _parsed(Path(path), "plug-in")
    classes = {part.name: part for part in parts if isinstance(part, ast.ClassDef)}
    bases = [attribute]
    for base in bases:  # which grows by the bases of the classes of this file
        if base in classes:
            bases += [ast.unparse(each).rpartition(".")[2] for each in classes.pop(base).bases]
    for part in parts:
        if isinstance(part, ast.FunctionDef) and part.name == attribute:
            return len(part.args.posonlyargs + part.args.args) - len(part.args.defaults) < 2
        if isinstance(part, (ast.Assign, ast.AnnAssign)) and attribute in ast.unparse(part).partition("=")[0]:
            return True
    return any(base.endswith("Problem") for base in bases[1:])


def _parsed(path: Path, kind: str) -> list[ast.stmt]:
    content = _content(path, kind)
    with explained(f"the {kind} file {path} cannot be read as Python", (SyntaxError, ValueError)):  # of a NUL byte
        return ast.parse(content).body


def load_optimizer(name: str, /, **options: Any) -> Optimizer:
    """Return the optimizer of that file with these parameters; a plain function becomes one.

    Raises:
        BenchError: where the file is missing or fails to run, or holds no such class or function, and for options that
            are no parameters or out of range.
    """
    file, _, attribute = name.rpartition(":")
    path = Path(file)
    return build(_optimizer(name, attribute, path, _content(path, "optimizer")), name, options)


def load_problem(name: str, /, **options: Any) -> Problem:
    """Return the problem of that file: an instance, or what a class or a function makes of these options.

    Raises:
        BenchError: where the file is missing or fails to run, or holds no such problem, or the options do not suit it.
    """
    file, _, attribute = name.rpartition(":")
    path = Path(file)
    module = _imported(path, _content(path, "problem"), "problem")
    if attribute not in vars(module):
        names = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]
        raise BenchError(f"{path} holds no problem called {attribute!r}{nearest(attribute, names)}")
    problem = vars(module)[attribute]
    if callable(problem) and not isinstance(problem, Problem):
        with explained(f"{name!r} cannot be made", Exception):  # the file may raise anything
            problem = problem(**options)
    if not isinstance(problem, Problem):
        raise BenchError(f"{attribute!r} of {path} is neither a Problem nor a class or function that makes one")
    return problem


def _content(path: Path, kind: str) -> bytes:
    with explained(f"the {kind} file {path} cannot be read"):
        return path.read_bytes()


@cache
def _optimizer(name: str, attribute: str, path: Path, content: bytes) -> type[Optimizer]:
    module = _imported(path, content)
    plugin = vars(module).get(attribute)
    if isinstance(plugin, type) and issubclass(plugin, Optimizer):
        if not is_frozen(plugin):
            return plugin  # build() refuses it
        return derive(plugin, name, {}, load_optimizer, __doc__=plugin.__doc__)
    if (inspect.isfunction(plugin) or isinstance(plugin, type)) and is_loose(plugin):
        return optimizer_of(plugin, name, load_optimizer)
    if attribute in vars(module):
        raise BenchError(
            f"{attribute!r} of {path} is neither an Optimizer subclass nor a function, nor a class with ask and tell, "
            "nor a class X(budget, dim) whose instances are called with the function"
        )
    names = [key for key, value in vars(module).items() if _is_own_optimizer(module, value)]
    raise BenchError(f"{path} holds no optimizer called {attribute!r}{nearest(attribute, names)}")


@cache
def _imported(path: Path, content: bytes, kind: str = "optimizer") -> ModuleType:
    """Import a plug-in's file as a module of its own, which can import the modules beside it."""
    name = f"bench_file_{path.stem}_{short_hash(content)}"  # an edited file is another module
    spec = spec_from_file_location(name, path)
    if spec is None:
        raise BenchError(f"the {kind} file {path} cannot be read as Python")
    folder = path.resolve().parent
    module = module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look up annotations there
    _folders.add(folder)
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    try:
        code = compile(content, str(path), "exec")  # not bytecode of what the file held before
        _refuse_namesakes(ast.parse(content), path, folder)
        exec(code, vars(module))
    except (Exception, SystemExit) as error:  # the file may raise anything
        del sys.modules[name]
        if isinstance(error, BenchError):
            raise
        raise BenchError(f"the {kind} file {path} failed to load: {type(error).__name__}: {error}") from error
    return module


_folders: set[Path] = set()  # of plug-ins' files, which Python searches last


def _refuse_namesakes(tree: ast.Module, path: Path, folder: Path) -> None:
    """Raise BenchError where a file imports a module beside it, and one of that name is loaded from elsewhere."""
    others = observing.modules()
    for node in ast.walk(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module or ""]
        for name in names:
            loaded = others.get(name)
            beside = next(filter(Path.exists, (folder / f"{name}.py", folder / name / "__init__.py")), None)
            home = Path(loaded).resolve().parents[beside.name == "__init__.py"] if beside and loaded else folder
            if home != folder and home in _folders:  # all else Python finds first, for both
                raise BenchError(
                    f"{path} imports {beside} and another plug-in imports {loaded}, but a process loads one module of "
                    "a name alone; rename one of them"
                )


def _is_own_optimizer(module: ModuleType, value: object) -> bool:
    is_own = getattr(value, "__module__", None) == module.__name__
    return is_own and (inspect.isfunction(value) or (isinstance(value, type) and issubclass(value, Optimizer)))
