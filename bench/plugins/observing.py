"""Observe what a process reads: the files, packages and variables that its trials are made from.

An audit hook, set before any plug-in is loaded, notes each file as it is opened, with a hash of what it holds then.
Processes that are forked later know what was read before. Not seen are files that C code opens by itself, what other
processes read, and settings of the system.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import stat
import sys
import sysconfig
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from glob import glob
from importlib.machinery import all_suffixes
from importlib.util import source_from_cache
from pathlib import Path
from threading import local
from traceback import walk_stack
from types import CodeType, FrameType
from typing import Any

from bench.contract import objective
from bench.helpers.errors import BenchError
from bench.helpers.text import short_hash

Signature = list[int]
"""Size, both times and number of a file, by which it is known not to have changed; empty of one just written."""

FileName = str | bytes | os.PathLike[str]

Observed = dict[str, dict[str, dict[str, Any]]]
"""What was read, by owner, kind and name; the owner is a label, or "" where whoever is loaded beside it may use it too.

``files`` have a hash and a signature; ``packages``, by the name of the module, the one that read them first;
``variables``, ``folders``, ``patterns`` and ``objects`` a hash; ``libraries`` are packages that a plug-in names.
"""

PARTS = "problem", "optimizer"
"""Whose inputs they are."""

_HOME = Path(__file__).resolve().parents[2]
_OBJECTIVE = objective.__file__
_SITES = "site-packages", "dist-packages"
_BENCH, _PYTHON = "bench", "python"  # what a file is part of, as _part_of() answers
_OUTSIDE = (
    "<frozen", "/usr/", "/proc/", "/sys/", "/etc/", "/dev/", "/lib/", "/lib64/", "/bin/",
    *(f"{each}{os.sep}" for each in (sys.prefix, sys.base_prefix, *map(sysconfig.get_path, ("stdlib", "platstdlib")))),
)  # fmt: skip
_NO_INPUT = "/.cache/matplotlib/", "/.config/matplotlib/", "/.cache/fontconfig/", ".dist-info/", ".egg-info/"
_NO_PACKAGE = ".dist-info", ".egg-info", ".pth"
_CODE = (
    *all_suffixes(), ".sh", ".r", ".R", ".jl", ".c", ".h", ".cpp", ".hpp", ".f90", ".m", ".lua", ".js", ".pl", ".rb",
)  # fmt: skip
_RACY = 2_000_000_000  # nanoseconds within which a file may be written again and keep its times
_BULK = 16  # variables that one place reads: then it copies the environment, and asks for none of them
_BLOCK = 1 << 20


class _State(local):
    busy = False  # whether this thread is in the hook, which opens files itself


class _Notes:
    """The notes of this process and of those that it was forked from."""

    def __init__(self) -> None:
        self.read: dict[str, Observed] = {}  # by whose inputs they are
        self.part = ""  # whose code is being loaded or run; "" for nobody's
        self.label = self.problem = ""  # of the problem or the optimizer, and of the last problem
        self.excluded: tuple[str, ...] = ()
        self.known: dict[str, tuple[str, Signature]] = {}  # hashes of large files with signatures, from earlier runs
        self.written: set[str] = set()  # by this process: no input, whoever reads it
        self.places: dict[tuple[CodeType, int], set[str]] = {}  # variables by the place that reads them
        self.digest = ""

    def add(self, kind: str, name: str, value: object, owner: str = "") -> None:
        part = self.part
        if not part:
            return
        callers = (frame.f_code.co_filename for frame, _ in walk_stack(sys._getframe()))
        if part == "optimizer" and _OBJECTIVE in callers:
            part, owner = "problem", owner and self.problem
        noted = self.read.setdefault(part, {}).setdefault(owner, {}).setdefault(kind, {})
        if noted.get(name) != value:
            noted[name] = value
            self.digest = ""

    def every(self, kind: str) -> list[dict[str, Any]]:
        """Return what is noted of that kind: of the problem and of the optimizer, and of each owner."""
        return [noted[kind] for read in self.read.values() for noted in read.values() if kind in noted]

    def of(self, kind: str, name: str) -> list[Any]:
        """Return what is noted by that name."""
        return [noted[name] for noted in self.every(kind) if name in noted]


_notes, _state = _Notes(), _State()


def observe(output: str = "", known: dict[str, tuple[str, Signature]] | None = None) -> None:
    """Note from now on what this process reads, and each that is forked from it.

    Args:
        output: the folder of results, whose files are no inputs.
        known: hashes of large files by path, with the signatures that they had.
    """
    _notes.excluded = tuple(f"{place}{os.sep}" for place in {output, os.path.realpath(output)} if output)
    _part_of.cache_clear()
    _notes.known |= known or {}
    if not getattr(sys, "_bench_observes", False):
        sys._bench_observes = True  # type: ignore[attr-defined]  # a hook stays for as long as the process
        sys.addaudithook(_hook)
        os.environ.__class__ = _Environment


@contextmanager
def reading(part: str, label: str = "") -> Iterator[None]:
    """Note what is read in this context as inputs of the problem or of the optimizer of that label."""
    before = _notes.part, _notes.label
    _notes.part, _notes.label = part, label
    _notes.problem = label if part == "problem" else _notes.problem
    try:
        yield
    finally:
        _notes.part, _notes.label = before


def observed() -> dict[str, Observed]:
    """Return what was noted so far, by whose inputs they are."""
    return {part: _notes.read[part] for part in PARTS if part in _notes.read}


def modules() -> dict[str, str]:
    """Return the files of the modules of plug-ins that this process has loaded, by their names."""
    files = {name: getattr(module, "__file__", None) for name, module in [*sys.modules.items()]}
    places = {name: os.path.abspath(file) for name, file in files.items() if isinstance(file, str)}
    return {name: place for name, place in places.items() if not _part_of(place)}


def digest() -> str:
    """Return a hash of :func:`observed`, computed once for all trials between which nothing was noted."""
    _notes.digest = _notes.digest or hashlib.sha256(repr(observed()).encode()).hexdigest()
    return _notes.digest


note = _notes.add
"""Note an input that the process is known to use: an object of a session, or a package by the plug-in's word."""


def declare(patterns: Iterable[str]) -> None:
    """Note files that a study names as inputs; raises BenchError for a name of none, and for a file that changed."""
    before, _state.busy = _state.busy, True  # what is opened here is noted here
    try:
        for pattern in patterns:
            paths = matching(pattern)
            if not paths:
                raise BenchError(f"'files' names {pattern!r}, and there is no such file here")
            _notes.add("patterns", os.path.abspath(pattern), names_of(paths), _notes.label)
            for path in paths:
                _program_file(os.path.abspath(path))
    finally:
        _state.busy = before


def matching(pattern: str) -> list[str]:
    """Return the files whose names match a pattern, sorted."""
    return [path for path in sorted(glob(pattern, recursive=True)) if os.path.isfile(path)]


def names_of(paths: Iterable[str]) -> str:
    """Return the hash of the names of files."""
    return short_hash("\n".join(map(os.path.basename, paths)).encode(errors="replace"))


def hash_of(path: str) -> str:
    """Return the hash of a file's content, "" where there is none."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb", buffering=0) as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    except OSError:
        return ""
    return digest.hexdigest()[:16]


def listing(folder: str) -> str:
    """Return the hash of the names of a folder's files, "" where there is none."""
    try:
        with os.scandir(folder or ".") as entries:
            return names_of(sorted(each.name for each in entries if each.is_file() and not each.name.startswith(".")))
    except OSError:
        return ""


def variable(value: str | None) -> str:
    """Return the hash that stands for a variable's value, "" for one that is not set."""
    return "" if value is None else short_hash(value.encode(errors="replace"))


def signature(path: str) -> Signature:
    """Return the signature of a regular file.

    Raises:
        OSError: where there is no such file.
    """
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):
        raise OSError(f"{path} is no regular file")
    if time.time_ns() - max(status.st_mtime_ns, status.st_ctime_ns) < _RACY:
        return []
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]


# the hook


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if event not in _HANDLERS or _state.busy or not _notes.part:
        return
    _state.busy = True
    try:
        _HANDLERS[event](*arguments)
    except (BenchError, _NoKernelError):
        raise
    except Exception:
        pass
    finally:
        _state.busy = False


def _opened(path: FileName, mode: object = "r", flags: int = 0, *_: object) -> None:
    place = _absolute(path)
    if flags & (os.O_WRONLY | os.O_CREAT | os.O_TRUNC):
        _notes.written.add(place)
    elif place.endswith((".nbi", ".nbc")):
        _refuse_kernels(place)
    else:
        _read(place)


def _imported(module: str, file: FileName | None = None, *_: object) -> None:
    if file is not None:  # of a module in machine code
        _read(_absolute(file))


def _linked(name: FileName, *_: object) -> None:
    if os.path.exists(name):  # else the system looks for it
        _read(_absolute(name))


def _listed(path: FileName | None = None, *_: object) -> None:
    place = _absolute("." if path is None else path)
    imports = "importlib" in sys._getframe(2).f_code.co_filename
    if not (imports or _reader()[0] or _part_of(place) or os.path.basename(place) in _SITES):
        _notes.add("folders", place, listing(place))


def _started(
    executable: FileName | None, words: str | Sequence[FileName], folder: FileName | None = None, *_: object
) -> None:
    """Note the files of a program: itself, those among its words, and code beside them."""
    words = shlex.split(words) if isinstance(words, str) else [os.fsdecode(word) for word in words]
    folder = os.fsdecode(folder) if folder is not None else os.getcwd()
    program = os.path.abspath(shutil.which(os.fsdecode(executable or words[0])) or "")
    paths = [program, *(os.path.abspath(os.path.join(folder, word.rpartition("=")[2])) for word in words[1:])]
    for place in (path for path in paths if os.path.isfile(path) and not _part_of(path)):
        _program_file(place)
        if place == program or place.endswith(_CODE):
            for beside in sorted(os.scandir(os.path.dirname(place)), key=lambda each: each.name):
                if beside.name.endswith(_CODE) and beside.is_file():
                    _program_file(beside.path)


_HANDLERS: dict[str, Callable[..., None]] = {
    "open": _opened, "import": _imported, "ctypes.dlopen": _linked, "sqlite3.connect": _linked,
    "subprocess.Popen": _started, "os.listdir": _listed, "os.scandir": _listed,
}  # fmt: skip


def _absolute(path: FileName) -> str:
    """Return the path of a file; raises TypeError for a descriptor, and ValueError for code without a file."""
    name = os.fsdecode(path)
    if name.startswith("<"):
        raise ValueError(f"{name} is no file")
    return os.path.abspath(name)


@cache
def _part_of(place: str) -> str:
    """Return what a file is part of: ``_PYTHON``, ``_BENCH``, the module of an installed package; "" of a plug-in.

    With Python go the system, caches, results and descriptions of packages, which decide no trial.
    """
    for site in _SITES:
        _, found, inside = place.partition(f"{os.sep}{site}{os.sep}")
        top = inside.partition(os.sep)[0]
        if found and not place.startswith(f"{_HOME / _BENCH}{os.sep}"):
            strange = top.endswith(_NO_PACKAGE) or top.startswith(("__editable__", "_editable_impl"))
            return _PYTHON if strange else top.partition(".")[0]
    if place.startswith(f"{_HOME / _BENCH}{os.sep}"):
        return _BENCH
    no_input = place.endswith(".bib") or any(each in place for each in _NO_INPUT)
    return _PYTHON if no_input or place.startswith((*_OUTSIDE, *_notes.excluded)) else ""


def _reader(top: str = _PYTHON) -> tuple[str, FrameType | None]:
    """Return what the code that reads is part of, and its frame: the innermost outside Python and that package."""
    for frame, _ in walk_stack(sys._getframe()):
        file = frame.f_code.co_filename
        if file != __file__ and (part := _part_of(file)) not in (_PYTHON, top):
            return part, frame
    return _PYTHON, None


def _read(place: str) -> None:
    top = _part_of(place)
    if top in (_PYTHON, _BENCH) or place in _notes.written:
        return
    if not top:
        _read_file(_source(place) if place.endswith(".pyc") else place)
    elif not _notes.of("packages", top):
        reader, _ = _reader(top)
        _notes.add("packages", top, "" if reader in (_PYTHON, _BENCH) else reader)


def _source(place: str) -> str:
    """Return the file that bytecode stands for; remove bytecode that may be of what the file held before.

    Python knows it by the size and the second of the file's last change.
    """
    try:
        source = source_from_cache(place)
        written = os.stat(source).st_mtime
    except (ValueError, OSError):
        return place
    with suppress(OSError):
        if written > os.stat(place).st_mtime - 2:
            os.unlink(place)
    return source


def _read_file(place: str, owner: str = "") -> str:
    """Note a file as it is now; return its hash."""
    try:
        now = signature(place)
    except OSError:
        if not os.path.exists(place) and not _reader()[0]:
            _notes.add("files", place, ["", []])
        return ""
    known = [*_notes.of("files", place), [*_notes.known.get(place, ("", []))]]
    value = next((each for each in known if now and each[1] == now), None) or [hash_of(place), now]
    _notes.add("files", place, value, owner)
    return str(value[0])


def _program_file(place: str) -> None:
    """Note a file of a program, which is started anew for each trial; raises BenchError where the file changed."""
    before = [content for content, _ in _notes.of("files", place)]
    if _read_file(place, _notes.label) not in before and before:
        raise BenchError(
            f"{place} changed while the study ran, so no trial is made with it: run the same command again, which "
            "makes all trials of the changed one"
        )


# numba's caches


def _refuse_kernels(place: str) -> None:
    """Have numba compile what is not of this package: it knows its files by their own dates, not by what they import.

    Raises:
        _NoKernelError: as where nothing was compiled yet.
    """
    is_installed = _part_of(place) not in ("", _PYTHON)
    if not (is_installed or place.startswith(f"{_HOME}{os.sep}") or any(each in place for each in _own_caches())):
        raise _NoKernelError(place)


@cache
def _own_caches() -> set[str]:
    """Return what numba calls the folders of this package's kernels, where it cannot write beside the code."""
    folders = [each for top in ("bench", "problems", "optimizers") for each, *_ in os.walk(_HOME / top)]
    return {hashlib.sha1(each.encode(), usedforsecurity=False).hexdigest() for each in folders}


class _NoKernelError(FileNotFoundError):
    """Raised in place of reading what numba compiled before."""


# the environment


class _Environment(type(os.environ)):  # type: ignore[misc]
    """The environment, which notes the variables that a plug-in's own code asks for."""

    def __getitem__(self, key: str) -> str:
        try:
            value = super().__getitem__(key)
        except KeyError:
            self._note(key, None)
            raise
        self._note(key, value)
        return str(value)

    def _note(self, key: str, value: str | None) -> None:
        if not _notes.part or _state.busy or key.endswith("_NUM_THREADS") or key == "PYTHONHASHSEED":
            return  # the last ones are set for processes of trials
        reader, frame = _reader()
        if reader or frame is None:
            return
        names = _notes.places.setdefault((frame.f_code, frame.f_lasti), set())
        names.add(key)
        if len(names) <= _BULK:
            _notes.add("variables", key, variable(value))
        else:
            for noted in _notes.every("variables"):
                for each in names & noted.keys():
                    del noted[each]
