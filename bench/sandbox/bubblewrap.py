"""Run processes in a sandbox of bubblewrap (Linux): nothing to write to, no network, and no other process in sight.

Each has namespaces of its own (mounts, processes, interprocess communication, network), which end with it: so do its
files, its shared memory, its message queues, and all processes that it has started.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import struct
import subprocess
import sys
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from bench.helpers.errors import BenchError
from bench.sandbox import namespaces

HIDDEN = ("/tmp", "/var/tmp", "/run")
"""Folders that are empty in a sandbox, but for what processes need to read: programs outside leave sockets there."""

SYSTEM = (
    "/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/opt", "/nix", "/sys",
    *(f"/etc/{name}" for name in ("alternatives", "fonts", "group", "ld.so.cache", "ld.so.conf", "ld.so.conf.d",
                                  "localtime", "locale.alias", "nsswitch.conf", "passwd", "R")),
)  # fmt: skip
"""Folders and files of the operating system that programs need to run."""

VARIABLES = ("HOME", "LANG", "LC_ALL", "LC_CTYPE", "LD_LIBRARY_PATH", "NUMBA_DISABLE_JIT", "PATH", "TZ")
"""The variables of the environment that processes in a sandbox find, where they are set; others may hold secrets."""

_SECONDS = 20.0  # for the sandbox to start


@dataclass(frozen=True)
class Sandbox:
    """The command line that runs a program in a sandbox.

    Attributes:
        words: to put before that of the program.
        nests: whether a process in the sandbox can have namespaces of its own.
    """

    words: tuple[str, ...]
    nests: bool = True

    @contextmanager
    def opened(self) -> Iterator[tuple[list[str], list[int]]]:
        """Yield these words and the numbers of the open files to pass on with them."""
        with os.fdopen(os.memfd_create("filter"), "wb") as file:
            file.write(_filter())
            file.flush()
            file.seek(0)
            number = file.fileno()
            yield [*self.words, "--seccomp", str(number), "--"], [number]


def find(
    *,
    shown: Iterable[Path] = (),
    hidden: Iterable[Path] = (),
    kernels: Iterable[Path] = (),
    only: Iterable[Path] | None = None,
) -> Sandbox:
    """Return the sandbox for code that nobody trusts.

    Args:
        shown: files and folders that processes need to read, wherever they are.
        hidden: files and folders that they must not read.
        only: folders beside ``shown`` and the operating system's that alone can be read; None for all that this process
            can read.
        kernels: the files of numba's caches beside the code, which no process need compile once more.

    Raises:
        BenchError: where bubblewrap is not installed or cannot be used.
    """
    program = shutil.which("bwrap")
    if program is None:
        raise BenchError(
            "--untrusted needs bubblewrap (Linux), which is not installed here; install it (on Debian and Ubuntu: apt "
            "install bubblewrap; on Fedora: dnf install bubblewrap)"
        )
    if only is None:
        readable, needed = {Path("/")}, {path for path in (*shown, *_installed()) if _is_below(path, HIDDEN)}
    else:
        readable, needed = {*map(Path, SYSTEM)}, {*shown, *only}
        hidden = [path for path in hidden if path in needed or _is_below(path, needed)]
    sandboxed = Sandbox((program, *_words(readable, needed, [*hidden], kernels)))
    if reason := _refusal(sandboxed, "true"):
        raise BenchError(f"--untrusted needs bubblewrap, which cannot be used here: {reason}")
    if _refusal(sandboxed, "test", "!", "-w", _SETTING):
        raise BenchError(
            "--untrusted cannot be used here by root: its sandbox would leave the settings of the kernel in /proc/sys "
            "writable; use another user"
        )
    script = Path(namespaces.__file__).read_text()
    return replace(sandboxed, nests=not _refusal(sandboxed, sys.executable, "-ISc", script))


def _refusal(sandbox: Sandbox, *command: str) -> str:
    """Return why a command fails in the sandbox, "" where it does not."""
    try:
        with sandbox.opened() as (words, files):
            tried = subprocess.run(
                [*words, *command], capture_output=True, text=True, timeout=_SECONDS, check=False, pass_fds=files
            )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return (tried.stderr.strip().splitlines() or ["it ended"])[-1] if tried.returncode else ""


def _words(
    readable: Iterable[Path], shown: Iterable[Path], hidden: Collection[Path], kernels: Iterable[Path]
) -> Iterator[str]:
    yield from ("--unshare-all", "--unshare-user", "--uid", _USER, "--gid", _USER, "--die-with-parent")
    yield from ("--cap-drop", "ALL", *_bound(readable), "--proc", "/proc", "--ro-bind-try", "/proc/sys", "/proc/sys")
    yield from ("--dev", "/dev", "--size", str(namespaces.SIZE), "--tmpfs", namespaces.SCRATCH)
    for folder in HIDDEN:
        yield from ("--tmpfs", folder)
    yield from _bound(shown)
    for path in hidden:
        yield from ("--tmpfs", str(path)) if path.is_dir() else ("--ro-bind", "/dev/null", str(path))
    for folder in (*HIDDEN, "/dev", *(str(path) for path in hidden if path.is_dir())):
        yield from ("--remount-ro", folder)
    caches = {"NUMBA_CACHE_DIR": "numba", "MPLCONFIGDIR": "matplotlib"}
    for name, folder in ({"TMPDIR": ""} | caches).items():
        yield from ("--setenv", name, str(Path(namespaces.SCRATCH, folder)))
    for path in kernels:  # numba refuses a cache that it cannot write to; the links lie where it looks for files
        code = path.parent.parent
        hashed = hashlib.sha1(str(code).encode(), usedforsecurity=False).hexdigest()
        place = Path(namespaces.SCRATCH, caches["NUMBA_CACHE_DIR"], f"{code.name}_{hashed}", path.name)
        yield from ("--symlink", str(path), str(place))


def _bound(paths: Iterable[Path]) -> Iterator[str]:
    whole: set[Path] = set()
    for path in sorted(paths):  # a folder comes before what lies in it, which is bound with it
        if not _is_below(path, whole):
            whole.add(path)
            yield from ("--ro-bind-try", str(path), str(path))


def _is_below(path: Path, folders: Iterable[str | Path]) -> bool:
    return any(Path(folder) in path.parents for folder in folders)


def _installed() -> set[Path]:
    """Return the folders that Python and its packages are imported from, and the working folder."""
    return {Path(folder).resolve() for folder in (sys.prefix, sys.base_prefix, *sys.path) if folder} | {Path.cwd()}


def _filter() -> bytes:
    """Return the program by which the kernel refuses the system calls that reach out of the namespaces.

    These are the calls of the keyring, which is one for all; those of io_uring, whose requests no filter sees; sockets
    of every family, by some of which programs outside answer; and pairs of sockets other than streams, which can send
    to the name of another socket. Pairs of streams remain. The form is that of seccomp(2): each instruction is an
    operation, two jumps and a number. On a processor not known here, nothing is refused.
    """
    calls = _CALLS.get(platform.machine())
    if calls is None:
        return struct.pack("<HBBI", _RETURN, 0, 0, _ALLOW)
    architecture, refused, pair = calls
    program = [
        (_LOAD, 0, 0, 4), (_EQUAL, 1, 0, architecture), (_RETURN, 0, 0, _REFUSE),
        (_LOAD, 0, 0, 0), (_AT_LEAST, 0, 1, 1 << 30), (_RETURN, 0, 0, _REFUSE),  # other tables of calls
    ]  # fmt: skip
    for number in (*refused, *_RINGS):
        program += [(_EQUAL, 0, 1, number), (_RETURN, 0, 0, _REFUSE)]
    program += [
        (_EQUAL, 0, 4, pair), (_LOAD, 0, 0, 24), (_AND, 0, 0, _KIND), (_EQUAL, 1, 0, _STREAM), (_RETURN, 0, 0, _REFUSE),
        (_RETURN, 0, 0, _ALLOW),
    ]  # fmt: skip
    return b"".join(struct.pack("<HBBI", *instruction) for instruction in program)


_LOAD, _EQUAL, _AT_LEAST, _AND, _RETURN = 0x20, 0x15, 0x35, 0x54, 0x06  # linux/bpf_common.h
_ALLOW, _REFUSE = 0x7FFF0000, 0x00050001  # linux/seccomp.h; refused with EPERM
_STREAM, _KIND = 1, 0xF  # SOCK_STREAM, and the bits of a type of sockets that are no flags
_USER = "1000"  # the number of the user and of the group in there, as namespaces inside cannot have those of root
_SETTING = "/proc/sys/kernel/hostname"  # root outside may write to it, without any privilege in a namespace
_RINGS = 425, 426, 427  # io_uring, on every processor
_CALLS = {  # the architecture (linux/audit.h), the calls add_key, request_key, keyctl and socket, and socketpair
    "x86_64": (0xC000003E, (248, 249, 250, 41), 53),
    "aarch64": (0xC00000B7, (217, 218, 219, 198), 199),
}
