"""Load plug-ins from code that is not installed: of a file, as ``path/to/file.py:Name``, or of a text."""

from __future__ import annotations

import ast
import inspect
import re
import sys
import traceback
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from bench.contract.optimizer import Optimizer
from bench.helpers.errors import BenchError, explained, nearest
from bench.helpers.text import listed, short_hash
from bench.plugins import observing
from bench.plugins.functions import shape, taken
from bench.sandbox.messages import describe_error

SOURCE = "<candidate>"
"""The file that tracebacks name for a text."""


def split(name: str) -> tuple[Path, str] | None:
    """Return file and attribute of a name such as ``"my/file.py:Mine"``, or None for a name of another form."""
    path, colon, attribute = name.rpartition(":")
    return (Path(path), attribute) if colon and path.endswith(".py") else None


def require_class(name: str) -> None:
    """Raise BenchError for the name of a Python file without a class behind it, naming those in it; it is not run."""
    if not name.endswith(".py"):
        return
    kinds = (ast.ClassDef, ast.FunctionDef)
    names = [key for key, part in _parts(f"{name}:").items() if isinstance(part, kinds) and not key.startswith("_")]
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
    parts = _parts(name)

    def is_one(name: str) -> bool:
        part = parts.pop(name, None)
        if isinstance(part, ast.ClassDef):
            bases = [ast.unparse(base).rpartition(".")[2] for base in part.bases]
            return any(base.endswith("Problem") or is_one(base) for base in bases)
        if isinstance(part, ast.FunctionDef):
            return len(part.args.posonlyargs + part.args.args) - len(part.args.defaults) < 2
        return part is not None

    return is_one(name.rpartition(":")[2])


def _parts(name: str) -> dict[str, ast.stmt]:
    """Return the statements of a file that give a name to a class, a function or another object, by that name."""
    parts: dict[str, ast.stmt] = {}
    with explained(f"the file {name.rpartition(':')[0]} cannot be read as Python", (SyntaxError, ValueError)):
        body = ast.parse(content(name)).body  # ValueError: of a NUL byte
    for part in body:
        if isinstance(part, (ast.ClassDef, ast.FunctionDef)):
            parts[part.name] = part
        elif isinstance(part, (ast.Assign, ast.AnnAssign)):
            targets = part.targets if isinstance(part, ast.Assign) else [part.target]
            parts |= {ast.unparse(target): part for target in targets}
    return parts


def content(name: str) -> bytes:
    """Return the content of the file of such a name; raises BenchError where it cannot be read."""
    path = Path(name.rpartition(":")[0])
    with explained(f"the file {path} cannot be read"):
        return path.read_bytes()


def attribute(name: str, content: bytes, kind: str) -> Any:
    """Return what a file of this content has by such a name.

    Raises:
        BenchError: where it fails to run, or has nothing of that name.
    """
    file, _, own = name.rpartition(":")
    module = _imported(Path(file), content)
    if own not in vars(module):
        names = [key for key, value in vars(module).items() if _is_own(value, module)]
        raise BenchError(f"{file} holds no {kind} called {own!r}{nearest(own, names)}")
    return vars(module)[own]


@cache
def _imported(path: Path, content: bytes) -> ModuleType:
    """Import a plug-in's file as a module of its own, which can import the modules beside it."""
    module = ModuleType(f"bench_file_{path.stem}_{short_hash(content)}")  # an edited file is another module
    module.__file__ = str(path)
    folder = path.resolve().parent
    _folders.add(folder)
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    _refuse_namesakes(content.decode(errors="replace"), path, folder)
    with explained(f"the file {path} failed to load", (Exception, SystemExit)):  # it may raise anything
        _run(content, str(path), module)
    return module


_folders: set[Path] = set()  # of plug-ins' files, which Python searches last


def _refuse_namesakes(text: str, path: Path, folder: Path) -> None:
    """Raise BenchError where a file imports a module beside it, and one of that name is loaded from elsewhere."""
    for name, loaded in observing.modules().items():
        place = Path(loaded).resolve()
        home = place.parents[place.name == "__init__.py"]
        beside = folder / place.relative_to(home)
        imports = rf"^\s*(?:from|import)\s[^#\n]*\b{re.escape(name)}\b"
        if home in _folders - {folder} and beside.exists() and re.search(imports, text, re.MULTILINE):
            raise BenchError(
                f"{path} imports {beside} and another plug-in imports {loaded}, but a process loads one module of "
                "a name alone; rename one of them"
            )


def _run(code: str | bytes, file: str, module: ModuleType) -> None:
    sys.modules[module.__name__] = module  # dataclasses look up annotations there
    exec(compile(code, file, "exec"), vars(module))


def _is_own(value: object, module: ModuleType) -> bool:
    return getattr(value, "__module__", None) == module.__name__


# texts, as language models write them


def from_source(text: str) -> Any:
    """Run the text of a Python file; return the last class or function in it that can be an optimizer.

    A function is one that takes ``objective`` first or ``rng`` second.

    Raises:
        BenchError: where there is none, or the text raises.
    """
    module = ModuleType("candidate")
    with explained("the source cannot be loaded", (Exception, SystemExit)):
        _run(text, SOURCE, module)
    found = [value for value in vars(module).values() if _is_own(value, module) and _fits(value)]
    if not found:
        raise BenchError(
            "the source defines no optimizer: it needs a class X(budget, dim) with __call__(self, func), a function "
            "(objective, rng), a class with ask and tell, or a bench.Optimizer"
        )
    return found[-1]


def _fits(value: object) -> bool:
    if isinstance(value, type):
        return not inspect.isabstract(value) if issubclass(value, Optimizer) else shape(value) is not None
    first = [*taken(value)][:2] if inspect.isfunction(value) else []
    return len(first) == 2 and (first[0] == "objective" or first[1] == "rng")


def located(error: BaseException) -> str:
    """Return an error as :func:`describe_error` does; one in a text begins with the line, as in "line 12: …"."""
    inner = error
    while isinstance(inner, BenchError) and inner.__cause__ is not None:
        inner = inner.__cause__
    lines = [frame.lineno for frame in traceback.extract_tb(inner.__traceback__) if frame.filename == SOURCE]
    if isinstance(inner, SyntaxError) and inner.filename == SOURCE:
        lines.append(inner.lineno)
    return f"line {lines[-1]}: {describe_error(inner)}" if lines else describe_error(error)
