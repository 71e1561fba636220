"""Have processes load the files of plug-ins as they were read once, whatever stands on the disk by then."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from tempfile import mkdtemp
from types import CodeType

from bench.plugins.code import Module

Files = dict[str, dict[str, Module]]
"""The files of plug-ins and of all that they import, by the path of the file, or the module, that is loaded."""


def take(files: Files) -> None:
    """Have this process load these files with this content."""
    taken.update(files)
    for module in (module for found in files.values() for module in found.values()):
        if module.path.suffix == ".py":
            _finder.take(module)
    if _finder not in sys.meta_path:
        sys.meta_path.insert(0, _finder)


def changed(files: Files) -> list[str]:
    """Return the paths of files whose content on the disk is another one, or that are no longer there."""
    different = {}
    for named, found in files.items():
        for path, content in found.values():
            with suppress(OSError):
                if path.read_bytes() == content:
                    continue
            different[path] = named if Path(named).resolve() == path else str(path)
    return list(different.values())


taken: Files = {}
"""The files that this process has taken."""


class ContentLoader(SourceFileLoader):
    """Compiles a file's content as it was read: the file may have changed since, and cached bytecode before."""

    def __init__(self, name: str, path: str, content: bytes) -> None:
        super().__init__(name, path)
        self._content = content

    def get_data(self, path: str) -> bytes:
        """Return the content of the file, or that of another one beside it."""
        return self._content if path == self.path else super().get_data(path)

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002 - a loader's signature
        """Return the compiled content.

        Where the file has changed, its path is that of a copy: numba keeps machine code by path and date of a file, and
        would take that of the old content for that of the new one.
        """
        place = Path(self.path)
        with suppress(OSError):
            if place.read_bytes() == self._content:
                return self.source_to_code(self._content, self.path)
        copy = Path(mkdtemp(prefix="bench-"), place.name)
        copy.write_bytes(self._content)
        return self.source_to_code(self._content, str(copy))


class _Finder:
    """Finds the modules of plug-ins where Python would, and loads the content that the run has read once.

    It finds those whose file is gone by now, too.
    """

    def __init__(self) -> None:
        self._contents: dict[str, dict[Path, bytes]] = {}  # by the last part of the module's name

    def take(self, module: Module) -> None:
        path, content = module
        name = path.parent.name if path.stem == "__init__" else path.stem
        self._contents.setdefault(name, {})[path] = content

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        tail = name.rpartition(".")[2]
        if tail not in self._contents:
            return None
        others = (finder.find_spec for finder in sys.meta_path if finder is not self and hasattr(finder, "find_spec"))
        found = next(filter(None, (find(name, path, target) for find in others)), None)  # type: ignore[arg-type]
        gone = (Path(place, file) for place in path or sys.path for file in (f"{tail}/__init__.py", f"{tail}.py"))
        for file in [Path(found.origin)] if found is not None and found.origin else gone:
            if (content := self._contents[tail].get(file.resolve())) is not None:
                return spec_from_file_location(name, file, loader=ContentLoader(name, str(file), content))
        return None


_finder = _Finder()
