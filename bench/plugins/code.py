"""Identify the code that decides an optimizer's trials: files by their syntax trees, installed packages by version.

A file counts with every module that it imports, directly or through others, from outside the standard library and
installed packages: beside it, in its package, in its checkout. Imports are found in the syntax tree, so nothing is run.
Comments, docstrings and layout do not count. What a file imports otherwise (a name put together at run time, a folder
that it adds to ``sys.path``) is not found.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
import sysconfig
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.machinery import BuiltinImporter, FrozenImporter, ModuleSpec, PathFinder
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any, NamedTuple

from bench.errors import BenchError
from bench.optimizer import Optimizer
from bench.plugins import registry
from bench.plugins.syntax import FileFacts, facts

Code = dict[str, str]
"""What decides trials: a hash by file, named as Python finds it (``mine.py``, ``pkg/inner.py``), a version by package.
"""


class Module(NamedTuple):
    """A module's file, as it was read once."""

    path: Path
    content: bytes

    @property
    def facts(self) -> FileFacts:
        """The parts of it that decide trials."""
        return facts(self.content, self.path.suffix == ".py")


def modules(file: Path, content: bytes, read: Callable[[Path], bytes] = Path.read_bytes) -> dict[str, Module]:
    """Return a plug-in's file, first, and the files of all modules that it imports, by the names that they count under.

    Args:
        file: the path of the plug-in's file; Python imports it with its folder as the last place to search.
        content: what it holds.
        read: returns the content of a file that is imported; raises OSError where there is none.
    """
    home = file.resolve()
    found = {home.name: Module(home, content)}
    for name, module in _trace(facts(content).imported(""), _places(home.parent), read).items():
        if module.path != home:  # which may be imported in a circle
            found[name if name not in found else Path(os.path.relpath(module.path, home.parent)).as_posix()] = module
    return found


def linked(module: str, read: Callable[[Path], bytes] = Path.read_bytes) -> dict[str, Module]:
    """Return the files of a module and of all that it imports, by name, without what is installed other than by a link.

    ``read`` is as for :func:`modules`.
    """
    return _trace([module], _places(), read)


def hashes(found: Mapping[str, Module]) -> Code:
    """Return the hash of every file, by name: of its syntax tree, and of its bytes where it is no valid Python."""
    return {name: module.facts.digest for name, module in found.items()}


def identity(optimizer: Optimizer) -> Code:
    """Return the code that decides the trials of a loaded optimizer.

    These are its own ``fingerprint``, the versions of the packages that hold its classes and of the ``libraries`` that
    it declares, and the files of classes that are not installed, or only as a link to their checkout. The harness
    itself does not count.

    Raises:
        BenchError: for libraries that are no names of installed packages.
    """
    libraries, files = optimizer.libraries, Code()
    are_names = isinstance(libraries, (tuple, list)) and all(isinstance(name, str) for name in libraries)
    if not are_names or len(names := set(libraries)) > len(versions(libraries)):
        raise BenchError(
            f"the 'libraries' of {type(optimizer).__name__} must be names of packages that are installed here, as in "
            f"('cma',), not {libraries!r}"
        )
    for module in defining([optimizer]):
        spec = getattr(sys.modules.get(module), "__spec__", None)
        if spec is not None and _is_installed(spec):
            names |= set(distributions(module))
        else:
            files |= _hashes_of_module(module)
    return files | versions(names) | dict(optimizer.fingerprint)


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return the names, as of files and packages, that are new, gone or changed."""
    return [name for name in {**before, **now} if before.get(name) != now.get(name)]


def versions(names: Iterable[str]) -> Code:
    """Return the versions of those distributions that are installed, by name."""
    found = Code()
    for name in sorted(set(names)):
        with suppress(PackageNotFoundError, ValueError):  # ValueError: an empty name
            found[name] = version(name)
    return found


def defining(plugins: Iterable[object]) -> list[str]:
    """Return the names of the modules that define the plug-ins' classes and the functions they hold."""
    names: set[str] = set()
    for plugin in plugins:
        kind = type(plugin)
        held = [*vars(kind).values(), *getattr(plugin, "__dict__", {}).values()]
        owners = [*kind.__mro__, *(value for value in held if callable(value) and not isinstance(value, type))]
        names |= {name for owner in owners if isinstance(name := getattr(owner, "__module__", None), str)}
    return sorted(name for name in names if not _is_everywhere(name))


def distributions(module: str) -> list[str]:
    """Return the names of the distributions that a module belongs to, none for a file that is not installed."""
    top = module.partition(".")[0]
    entries = (entry for group in ("optimizers", "problems") for entry in registry.entries(group).values())
    found = {entry.dist.name for entry in entries if entry.dist and entry.module.partition(".")[0] == top}
    return sorted(found) or sorted(set(_distributions().get(top, [])))


# which modules


def _trace(wanted: Iterable[str], places: Sequence[str], read: Callable[[Path], bytes]) -> dict[str, Module]:
    """Return the files of these modules and of all that they import, without what is installed, by their names."""
    importlib.invalidate_caches()  # of folders in which a file was made a moment ago
    specs: dict[str, ModuleSpec | None] = {}
    found: dict[str, Module] = {}
    exports: dict[str, tuple[str, ...]] = {}
    left = deque(wanted)
    while left:
        dotted = left.popleft()
        package, name = "", ""
        for part in dotted.split("."):
            if part == "*":
                left.extend(f"{package}.{export}" for export in exports.get(package, ()))
                break
            name = f"{package}.{part}".lstrip(".")
            if name not in specs:
                specs[name] = spec = _spec(name, places, specs.get(package))
                if spec is not None and (module := _module(spec, read)):
                    found[_path_in_package(spec, module.path)] = module
                    exports[name] = module.facts.exports
                    inside = name if spec.submodule_search_locations is not None else package
                    left.extend(module.facts.imported(inside))
            if getattr(specs[name], "submodule_search_locations", None) is None:
                break
            package = name
    return {name: found[name] for name in sorted(found)}


def _spec(name: str, places: Sequence[str], package: ModuleSpec | None) -> ModuleSpec | None:
    """Return Python's spec of a module whose package is known; None for a module that counts for no optimizer.

    Unlike :func:`importlib.util.find_spec`, it imports no package.
    """
    if package is None:
        if _is_everywhere(name):
            return None
        others = [finder for finder in sys.meta_path if finder not in (BuiltinImporter, FrozenImporter, PathFinder)]
        found = (finder.find_spec(name, None, None) for finder in others if hasattr(finder, "find_spec"))
        spec = _found_in(name, places) or next(filter(None, found), None)  # of packages that are linked
    else:
        spec = _found_in(name, package.submodule_search_locations or ())
    return None if spec is None or _is_installed(spec) else spec


def _found_in(name: str, places: Iterable[str]) -> ModuleSpec | None:
    portions: list[str] = []
    for place in places:
        finder: Any = pkgutil.get_importer(place)
        spec: ModuleSpec | None = finder.find_spec(name) if finder is not None else None
        if spec is not None and spec.loader is not None:
            return spec
        portions += (spec and spec.submodule_search_locations) or []
    if not portions:
        return None
    namespace = ModuleSpec(name, None, is_package=True)
    namespace.submodule_search_locations = portions
    return namespace


def _places(*last: Path) -> list[str]:
    """Return the folders in which the processes of trials search for modules: installed packages first."""
    first = {str(Path(place).absolute()) for place in os.environ.get("PYTHONPATH", "").split(os.pathsep) if place}
    first |= {place for place in sys.path if place.startswith(_LIBRARY) or is_installed(Path(place))}
    path = sorted(sys.path, key=lambda place: place not in first)
    return [*path, *(str(place) for place in last if str(place) not in path)]


def _module(spec: ModuleSpec, read: Callable[[Path], bytes]) -> Module | None:
    with suppress(OSError):
        if spec.has_location and spec.origin:
            path = Path(spec.origin).resolve()
            return Module(path, read(path))
    return None


def _path_in_package(spec: ModuleSpec, path: Path) -> str:
    parts = spec.name.split(".")
    return "/".join([*(parts if spec.submodule_search_locations is not None else parts[:-1]), path.name])


def _is_everywhere(name: str) -> bool:
    """Return whether a module is of the harness, of the standard library or of no file."""
    return name.partition(".")[0] in {"bench", "__main__", *sys.stdlib_module_names}


def _is_installed(spec: ModuleSpec) -> bool:
    """Return whether a module is part of an installed package, which is no part of a checkout around it."""
    return bool(spec.has_location and spec.origin) and is_installed(Path(str(spec.origin)))


def is_installed(file: Path) -> bool:
    """Return whether a file is part of an installed package, which is no part of a checkout around it."""
    return not {"site-packages", "dist-packages"}.isdisjoint(file.parts)


@cache  # as the module was loaded once
def _hashes_of_module(name: str) -> Code:
    return hashes(linked(name))


_distributions = cache(packages_distributions)


_LIBRARY = tuple(sysconfig.get_paths()[key] for key in ("stdlib", "platstdlib"))
