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
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from glob import glob
from importlib.machinery import all_suffixes
from importlib.util import source_from_cache
from pathlib import Path
from threading import local
from types import FrameType
from typing import Any

from bench.errors import BenchError
from bench.helpers.text import short_hash

Signature = list[int]
"""Size, both times and number of a file, by which it is known not to have changed; empty of one just written."""

Observed = dict[str, dict[str, Any]]
"""What was read, by kind and name.

``files`` have a hash, whether they had been written long before, and a signature; ``packages``, by the name of the
module, the folder that they are installed in and the package that read them first; ``variables``, ``folders``,
``patterns`` and ``objects`` a hash; ``libraries`` are packages that a plug-in names. ``owners`` has the labels of those
that alone use a file.
"""

PARTS = "problem", "optimizer"
"""Whose inputs they are."""

_HOME = Path(__file__).resolve().parents[2]
_OWN = f"{_HOME / 'bench'}{os.sep}"
_OBJECTIVE = str(_HOME / "bench" / "objective.py")
_LIBRARY = tuple({f"{sysconfig.get_path(name)}{os.sep}" for name in ("stdlib", "platstdlib")})
_SITES = "site-packages", "dist-packages"
_SYSTEM = (
    "/usr/", "/proc/", "/sys/", "/etc/", "/dev/", "/lib/", "/lib64/", "/bin/", f"{sys.prefix}{os.sep}",
    f"{sys.base_prefix}{os.sep}",
)  # fmt: skip
_CACHES = "/.cache/matplotlib/", "/.config/matplotlib/", "/.cache/fontconfig/"
_CODE = (
    *all_suffixes(), ".sh", ".r", ".R", ".jl", ".c", ".h", ".cpp", ".hpp", ".f90", ".m", ".lua", ".js", ".pl", ".rb",
)  # fmt: skip
_RACY = 2_000_000_000  # nanoseconds within which a file may be written again and keep its times
_BULK = 16  # variables that one place reads: then it copies the environment, and asks for none of them
_BLOCK = 1 << 20
_EVENTS = {"open", "import", "ctypes.dlopen", "subprocess.Popen", "sqlite3.connect", "os.listdir", "os.scandir"}


class _State(local):
    busy = False  # whether this thread is in the hook, which opens files itself


class _Notes:
    """The notes of this process and of those that it was forked from."""

    def __init__(self) -> None:
        self.parts: dict[str, Observed] = {}
        self.part = ""  # whose code is being loaded or run; "" for nobody's
        self.label = self.problem = ""  # of the problem or the optimizer, and of the last problem
        self.owners: dict[str, set[str]] = {}  # labels by file; "" where whoever is loaded beside it may use it
        self.excluded: tuple[str, ...] = ()
        self.known: dict[str, tuple[str, Signature]] = {}  # hashes of files by signature, from earlier runs
        self.written: set[str] = set()  # by this process: no input, whoever reads it
        self.places: dict[tuple[Any, int], set[str]] = {}  # variables by the place that reads them
        self.revision, self.digests = 0, dict[int, str]()

    def add(self, kind: str, name: str, value: Any, owner: str = "") -> None:
        part = self.part
        if not part:
            return
        if part == "optimizer" and _in_the_objective():
            part, owner = "problem", owner and self.problem
        noted = self.parts.setdefault(part, {}).setdefault(kind, {})
        owners = self.owners.setdefault(name, set())
        if noted.get(name) != value or owner not in owners:
            noted[name] = value
            owners.add(owner)
            self.revision += 1


_notes, _state = _Notes(), _State()


def observe(output: str = "", known: dict[str, tuple[str, Signature]] | None = None) -> None:
    """Note from now on what this process reads, and each that is forked from it.

    Args:
        output: the folder of results, whose files are no inputs.
        known: hashes of large files by path, with the signatures that they had.
    """
    _notes.excluded = tuple(f"{place}{os.sep}" for place in {output, os.path.realpath(output)} if output)
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
    owners = {name: sorted(labels) for name, labels in _notes.owners.items() if "" not in labels}
    return {part: _notes.parts[part] | {"owners": owners} for part in PARTS if part in _notes.parts}


def modules() -> dict[str, str]:
    """Return the files of the modules of plug-ins that this process has loaded, by their names."""
    files = {name: getattr(module, "__file__", None) for name, module in [*sys.modules.items()]}
    return {
        name: place
        for name, file in files.items()
        if isinstance(file, str) and (place := os.path.abspath(file)) and _is_own(place) and not _is_outside(place)
    }


def digest() -> str:
    """Return a hash of :func:`observed`, computed once for all trials between which nothing was noted."""
    if _notes.revision not in _notes.digests:
        _notes.digests = {_notes.revision: hashlib.sha256(repr(observed()).encode()).hexdigest()}
    return _notes.digests[_notes.revision]


def note(kind: str, name: str, value: Any) -> None:
    """Note an input that the process is known to use: an object of a session, or a package by the plug-in's word."""
    _notes.add(kind, name, value)


def declare(patterns: Iterable[str]) -> None:
    """Note files that a study names as inputs; raises BenchError for a name of none, and for a file that changed."""
    before, _state.busy = _state.busy, True  # what is opened here is noted here
    try:
        for pattern in patterns:
            paths = matching(pattern)
            if not paths:
                raise BenchError(f"'files' names {pattern!r}, and there is no such file here")
            names = variable("\n".join(map(os.path.basename, paths)))
            _notes.add("patterns", os.path.abspath(pattern), names, _notes.label)
            for path in paths:
                _program_file(os.path.abspath(path))
    finally:
        _state.busy = before


def matching(pattern: str) -> list[str]:
    """Return the files whose names match a pattern, sorted."""
    return [path for path in sorted(glob(pattern, recursive=True)) if os.path.isfile(path)]


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
            names = sorted(each.name for each in entries if each.is_file() and not each.name.startswith("."))
    except OSError:
        return ""
    return short_hash("\n".join(names).encode(errors="replace"))


def variable(value: str | None) -> str:
    """Return the hash that stands for a variable's value, "" for one that is not set."""
    return "" if value is None else short_hash(value.encode(errors="replace"))


def signature(path: str) -> tuple[Signature, bool]:
    """Return the signature of a regular file, and whether it has been written long enough ago to be relied upon.

    Raises:
        OSError: where there is no such file.
    """
    status = os.stat(path)
    if not stat.S_ISREG(status.st_mode):
        raise OSError(f"{path} is no regular file")
    settled = time.time_ns() - max(status.st_mtime_ns, status.st_ctime_ns) > _RACY
    return [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino], settled


# the hook


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if event not in _EVENTS or _state.busy or not _notes.part:
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


def _opened(path: Any, mode: Any = "r", flags: int = 0, *_: Any) -> None:
    place = _absolute(path)
    if place is None:
        return
    if flags & (os.O_WRONLY | os.O_CREAT | os.O_TRUNC):
        _notes.written.add(place)
    elif place.endswith((".nbi", ".nbc")):
        _refuse_kernels(place)
    else:
        _read(place)


def _imported(module: str, file: Any = None, *_: Any) -> None:
    if file is not None and (place := _absolute(file)):  # of a module in machine code
        _read(place)


def _linked(name: Any, *_: Any) -> None:
    if isinstance(name, str | bytes | os.PathLike) and os.path.exists(name) and (place := _absolute(name)):
        _read(place)


def _listed(path: Any = ".", *_: Any) -> None:
    place = _absolute("." if path is None else path)
    frame = sys._getframe(2)
    if place is None or "importlib" in frame.f_code.co_filename or not _is_own(_reader(frame)):
        return
    if not (_is_outside(place) or any(f"{os.sep}{site}" in place for site in _SITES)):
        _notes.add("folders", place, listing(place))


def _started(executable: Any, words: Any, folder: Any = None, *_: Any) -> None:
    """Note the files of a program: itself, those among its words, and code beside them."""
    words = shlex.split(words) if isinstance(words, str) else [os.fsdecode(word) for word in words]
    folder = os.fsdecode(folder) if folder is not None else os.getcwd()
    program = shutil.which(os.fsdecode(executable or words[0])) or ""
    paths = [os.path.join(folder, word.rpartition("=")[2]) for word in words[1:]]
    for path in filter(os.path.isfile, [os.path.abspath(program), *paths]):
        place = os.path.abspath(path)
        if _is_outside(place) or place.startswith(f"{sys.prefix}{os.sep}"):
            continue
        _program_file(place)
        if place.endswith(_CODE) or place == os.path.abspath(program):
            for beside in sorted(os.scandir(os.path.dirname(place)), key=lambda each: each.name):
                if beside.name.endswith(_CODE) and beside.is_file():
                    _program_file(beside.path)


_HANDLERS: dict[str, Callable[..., None]] = {
    "open": _opened, "import": _imported, "ctypes.dlopen": _linked, "sqlite3.connect": _linked,
    "subprocess.Popen": _started, "os.listdir": _listed, "os.scandir": _listed,
}  # fmt: skip


def _absolute(path: Any) -> str | None:
    """Return the path of a file, None of a descriptor or of what has no path."""
    with suppress(TypeError, ValueError):
        if not isinstance(path, int) and not (name := os.fsdecode(path)).startswith("<"):
            return os.path.abspath(name)
    return None


def _is_outside(place: str) -> bool:
    """Return whether a file is no input: of Python, of the system, of this package, of a cache or a result."""
    if any(f"{os.sep}{site}{os.sep}" in place for site in _SITES):
        return place.startswith(_OWN)
    if place.startswith((*_SYSTEM, *_LIBRARY, _OWN, *_notes.excluded)):
        return True
    if place.endswith(".bib") or ".dist-info/" in place or ".egg-info/" in place:  # these decide no trial
        return True
    return any(each in place for each in _CACHES)


def _read(place: str) -> None:
    if _is_outside(place) or place in _notes.written:
        return
    for site in _SITES:
        before, found, inside = place.partition(f"{os.sep}{site}{os.sep}")
        if found:
            _read_package(f"{before}{os.sep}{site}", inside.partition(os.sep)[0])
            return
    if place.endswith(".pyc") and (source := _source(place)):
        place = source
    _read_file(place)


def _source(place: str) -> str | None:
    """Return the file that bytecode stands for; remove bytecode that may be of what the file held before.

    Python knows it by the size and the second of the file's last change.
    """
    try:
        source = source_from_cache(place)
        written = os.stat(source).st_mtime
    except (ValueError, OSError):
        return None
    with suppress(OSError):
        if written > os.stat(place).st_mtime - 2:
            os.unlink(place)
    return source


def _read_file(place: str, owner: str = "") -> str:
    """Note a file as it is now; return its hash."""
    try:
        now, settled = signature(place)
    except OSError:
        if not os.path.exists(place) and _is_own(_reader(sys._getframe(3))):
            _notes.add("files", place, ["", False, []])
        return ""
    for noted in _notes.parts.values():
        if (before := noted.get("files", {}).get(place)) and before[2] == now:
            if owner or "" not in _notes.owners[place]:
                _notes.add("files", place, before, owner)
            return str(before[0])
    known, of = _notes.known.get(place, ("", []))
    content = known if settled and of == now else hash_of(place)
    _notes.add("files", place, [content, settled, now], owner)
    return content


def _program_file(place: str) -> None:
    """Note a file of a program, which is started anew for each trial; raises BenchError where the file changed."""
    before = [noted["files"][place][0] for noted in _notes.parts.values() if place in noted.get("files", {})]
    if _read_file(place, _notes.label) not in (before or [_read_file(place, _notes.label)]):
        raise BenchError(
            f"{place} changed while the study ran, so no trial is made with it: run the same command again, which "
            "makes all trials of the changed one"
        )


def _read_package(site: str, name: str) -> None:
    if name.endswith((".dist-info", ".egg-info", ".pth")) or name.startswith(("__editable__", "_editable_impl")):
        return
    top = name.partition(".")[0]
    if not any(top in noted.get("packages", {}) for noted in _notes.parts.values()):
        reader = _reader(sys._getframe(3), top)
        inside = next((reader.partition(f"{os.sep}{each}{os.sep}")[2] for each in _SITES if each in reader), "")
        _notes.add("packages", top, [site, inside.partition(os.sep)[0].partition(".")[0]])


def _reader(frame: FrameType | None, top: str = "") -> str:
    """Return the file of the code that reads: the innermost outside Python's library and the package itself."""
    package = tuple(f"{os.sep}{site}{os.sep}{top}" for site in _SITES) if top else ()
    while frame is not None:
        file = frame.f_code.co_filename
        if not (_is_library(file) or file == __file__ or any(each in file for each in package)):
            return file
        frame = frame.f_back
    return ""


def _is_library(file: str) -> bool:
    return file.startswith(("<frozen", *_LIBRARY)) and not any(f"{os.sep}{site}{os.sep}" in file for site in _SITES)


def _is_own(file: str) -> bool:
    """Return whether code is a plug-in's, and not of this package or of another one that is installed."""
    return not (file.startswith(_OWN) or any(f"{os.sep}{site}{os.sep}" in file for site in _SITES))


def _in_the_objective() -> bool:
    frame: FrameType | None = sys._getframe(2)
    while frame is not None:
        if frame.f_code.co_filename == _OBJECTIVE:
            return True
        frame = frame.f_back
    return False


def _refuse_kernels(place: str) -> None:
    """Have numba compile what is not of this package: it knows its files by their own dates, not by what they import.

    Raises:
        _NoKernelError: as where nothing was compiled yet.
    """
    folder = os.path.dirname(place)
    if place.startswith(f"{_HOME}{os.sep}") or any(f"{os.sep}{site}{os.sep}" in place for site in _SITES):
        return
    ours = (str(_HOME / name) for name in ("bench", "problems", "optimizers"))
    if any(
        hashlib.sha1(each.encode(), usedforsecurity=False).hexdigest() in folder
        for top in ours
        for each, *_ in os.walk(top)
    ):
        return
    raise _NoKernelError(place)


class _NoKernelError(FileNotFoundError):
    """Raised in place of reading what numba compiled before."""


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
        frame: FrameType | None = sys._getframe(2)
        while frame is not None and _is_library(frame.f_code.co_filename):
            frame = frame.f_back
        if frame is None or not _is_own(frame.f_code.co_filename):
            return
        names = _notes.places.setdefault((frame.f_code, frame.f_lasti), set())
        names.add(key)
        if len(names) <= _BULK:
            _notes.add("variables", key, variable(value))
        else:
            for noted in _notes.parts.values():
                for name in names & noted.get("variables", {}).keys():
                    del noted["variables"][name]
