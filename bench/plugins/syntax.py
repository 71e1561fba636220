"""Read imports, exports and a hash from the syntax of a Python file, of which nothing is run.

The hash leaves out comments, docstrings and layout.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from typing import Any, NamedTuple

from bench.helpers.text import short_hash


class FileFacts(NamedTuple):
    """The parts of a file that decide trials.

    Attributes:
        digest: a hash of its syntax tree; of its bytes where it is no valid Python.
        imports: level, module and names of each import; an import in a function is one, too.
        exports: the names in its ``__all__``.
    """

    digest: str
    imports: tuple[tuple[int, str, tuple[str, ...]], ...] = ()
    exports: tuple[str, ...] = ()

    def imported(self, package: str) -> Iterator[str]:
        """Yield the full names of a module's imports; a name may be that of an attribute and no module."""
        parents = package.split(".") if package else []
        for level, module, names in self.imports:
            if level > len(parents):
                continue  # a file without a package has nothing relative
            above = parents[: len(parents) + 1 - level] if level else []
            base = ".".join([*above, *([module] if module else [])])
            yield base
            yield from (f"{base}.{name}" for name in names)


@lru_cache(maxsize=4096)
def facts(content: bytes, python: bool = True) -> FileFacts:
    """Return the facts of a file with this content; ``python`` is False where it is known to be no Python."""
    if python:
        # ValueError: a NUL byte; the last two: nesting that is too deep
        with suppress(SyntaxError, ValueError, RecursionError, MemoryError), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # as of an escape that is none
            tree = ast.parse(content)
            return FileFacts(_hash(tree), tuple(_imports(tree)), tuple(_exports(tree)))
    return FileFacts(short_hash(content))


def _hash(tree: ast.Module) -> str:
    """Return a hash of a syntax tree that every version of Python computes alike, unlike that of :func:`ast.dump`.

    Left out are texts that stand alone, such as docstrings, and fields that are empty: later versions add some.
    """
    pieces: list[str] = []
    left: list[Any] = [tree]
    while left:
        item = left.pop()
        if isinstance(item, ast.AST):
            fields = [(key, value) for key, value in ast.iter_fields(item) if not _is_empty(key, value)]
            pieces.append(f"{type(item).__name__} {' '.join(key for key, _ in fields)}")
            left.extend(value for _, value in fields)
        elif isinstance(item, list):
            kept = [each for each in item if not _is_text(each)]
            pieces.append(str(len(kept)))
            left.extend(kept)
        else:
            pieces.append(f"{type(item).__name__} {item!a}")
    return short_hash("\n".join(pieces))


def _is_empty(key: str, value: Any) -> bool:
    return value is None or value == [] or key in ("ctx", "kind", "type_comment")  # ctx follows from the place


def _is_text(item: Any) -> bool:
    """Return whether an item of the tree is a statement that is a text alone."""
    text = item.value if isinstance(item, ast.Expr) else None
    return isinstance(text, ast.Constant) and isinstance(text.value, str)


def _imports(tree: ast.Module) -> Iterator[tuple[int, str, tuple[str, ...]]]:
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                yield from ((0, alias.name, ()) for alias in names)
            case ast.ImportFrom(module, names, level):
                yield level, module or "", tuple(alias.name for alias in names)
            case ast.Call(ast.Name(called) | ast.Attribute(attr=called), [ast.Constant(str(name)), *_]):
                if called in ("import_module", "__import__") and not name.startswith("."):
                    yield 0, name, ()


def _exports(tree: ast.Module) -> Iterator[str]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and any(isinstance(n, ast.Name) and n.id == "__all__" for n in node.targets):
            with suppress(ValueError, TypeError):  # no list of plain texts
                yield from (name for name in ast.literal_eval(node.value) if isinstance(name, str))
