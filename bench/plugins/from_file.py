"""Load optimizers and problems from a Python file that is not installed, as ``path/to/file.py:ClassName``."""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Callable, Iterable
from functools import cache, partial
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from bench.errors import BenchError, explained, nearest
from bench.families import derive
from bench.helpers.text import listed, short_hash
from bench.optimizer import Optimizer, build, is_frozen
from bench.plugins import code, objects, registry
from bench.plugins.code import Module
from bench.plugins.files import ContentLoader, Files, taken
from bench.plugins.functions import asks_and_tells, optimizer_of
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
    path, _, attribute = name.rpartition(":")
    return build(_optimizer(name, attribute, tuple(_modules(Path(path), "optimizer").items())), name, options)


def load_problem(name: str, /, **options: Any) -> Problem:
    """Return the problem of that file: an instance, or what a class or a function makes of these options.

    Its fingerprint is a hash of the file, of the modules that it imports and of the problem's own fingerprint.

    Raises:
        BenchError: where the file is missing or fails to run, or holds no such problem, or the options do not suit it.
    """
    file, _, attribute = name.rpartition(":")
    path = Path(file)
    found = _modules(path, "problem")
    module = _imported(next(iter(found.values())), "problem")
    if attribute not in vars(module):
        names = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]
        raise BenchError(f"{path} holds no problem called {attribute!r}{nearest(attribute, names)}")
    problem = vars(module)[attribute]
    if callable(problem) and not isinstance(problem, Problem):
        with explained(f"{name!r} cannot be made", Exception):  # the file may raise anything
            problem = problem(**options)
    if not isinstance(problem, Problem):
        raise BenchError(f"{attribute!r} of {path} is neither a Problem nor a class or function that makes one")
    own = type(problem).fingerprint(problem)  # one that stands in the file may be loaded once more
    digest = short_hash(json.dumps([code.hashes(found), own]))
    object.__setattr__(problem, "fingerprint", partial(str, digest))  # also of a frozen dataclass
    return problem


def contents(optimizers: Iterable[str], problems: Iterable[str] = ()) -> Files:
    """Return the files of such names with all that they import, and those of optimizers that are installed as a link.

    Each file is read once, and nothing of it is run.

    Raises:
        BenchError: for a file that cannot be read, and where a problem's file and another one import different modules
            of one name, of which a process can load one alone.
    """
    once = cache(Path.read_bytes)

    def read(path: Path) -> bytes:
        return once(path.resolve())

    files: Files = {}
    for name, kind in [(name, "optimizers") for name in optimizers] + [(name, "problems") for name in problems]:
        if parts := split(name):
            files[str(parts[0])] = _modules(parts[0], kind[:-1], read)
            continue
        modules = objects.modules(kind, name) or ([_module(name)] if kind == "optimizers" else [])
        for module in {*modules} - {"", *files}:
            files |= {module: linked} if (linked := code.linked(module, read)) else {}
    for parts in filter(None, map(split, problems)):  # whose files are loaded in the processes of all optimizers, too
        _refuse_namesakes(str(parts[0]), files)
    return files


def _refuse_namesakes(problem: str, files: Files) -> None:
    imported = [*files[problem].items()][1:]
    for other, found in files.items():
        for shown, module in imported:
            if shown in [*found][1:] and found[shown].path != module.path:
                raise BenchError(
                    f"{problem} imports {module.path} and {other} imports {found[shown].path}, but a process loads one "
                    "module of a name alone; rename one of them"
                )


def fingerprint(name: str, files: Files) -> code.Code:
    """Return the hashes of an optimizer's code that :func:`contents` has read; none for an installed one."""
    parts = split(name)
    return code.hashes(files.get(str(parts[0]) if parts else _module(name), {}))


def _module(optimizer: str) -> str:
    """Return the module of an installed optimizer, "" where there is none."""
    entry = registry.entry("optimizers", optimizer)
    return entry.module if entry else ""


def _content(path: Path, kind: str, read: Callable[[Path], bytes] = Path.read_bytes) -> bytes:
    with explained(f"the {kind} file {path} cannot be read"):
        return read(path)


def _modules(path: Path, kind: str, read: Callable[[Path], bytes] = Path.read_bytes) -> dict[str, Module]:
    """Return the modules of a plug-in's file, which is the first of them."""
    return taken.get(str(path)) or code.modules(path, _content(path, kind, read), read)


@cache
def _optimizer(name: str, attribute: str, found: tuple[tuple[str, Module], ...]) -> type[Optimizer]:
    (_, file), *_ = found
    module, fingerprint = _imported(file), code.hashes(dict(found))
    plugin = vars(module).get(attribute)
    if isinstance(plugin, type) and issubclass(plugin, Optimizer):
        if not is_frozen(plugin):
            return plugin  # build() refuses it
        return derive(plugin, name, {}, load_optimizer, __doc__=plugin.__doc__, fingerprint=fingerprint)
    if inspect.isfunction(plugin) or (isinstance(plugin, type) and asks_and_tells(plugin)):
        return optimizer_of(plugin, name, load_optimizer, fingerprint=fingerprint)
    if attribute in vars(module):
        raise BenchError(
            f"{attribute!r} of {file.path} is neither an Optimizer subclass nor a function, nor a class with ask and "
            "tell"
        )
    names = [key for key, value in vars(module).items() if _is_own_optimizer(module, value)]
    raise BenchError(f"{file.path} holds no optimizer called {attribute!r}{nearest(attribute, names)}")


@cache
def _imported(file: Module, kind: str = "optimizer") -> ModuleType:
    """Import a plug-in's file as a module of its own, which can import the modules beside it."""
    path, content = file
    name = f"bench_file_{path.stem}_{short_hash(content)}"  # an edited file is another module
    spec = spec_from_file_location(name, path, loader=ContentLoader(name, str(path), content))
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
