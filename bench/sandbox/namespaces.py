"""Give a process namespaces of its own inside a sandbox, so that nothing that it does there outlives it (Linux)."""

from __future__ import annotations

import ctypes
import os
import sys
from pathlib import Path

SCRATCH = "/dev/shm"
"""The only folder that can be written in a sandbox: a memory file system of its own in each set of namespaces."""

SIZE = 1 << 30  # bytes of it

_NEW = 0x10000000 | 0x00020000 | 0x20000000 | 0x08000000 | 0x40000000  # user, mounts, processes, IPC, network: sched.h
_NOSUID, _NODEV = 2, 4  # sys/mount.h
_DUMPABLE = 4  # linux/prctl.h
_CAPABILITIES = 0x20080522  # the version of the sets in linux/capability.h


def enter() -> int:
    """Move to new namespaces without any privilege there; return 0 in a new process, which is their first.

    In this process, which stays outside of the new list of processes, return the other one's number.

    Raises:
        OSError: where the system refuses it.
    """
    user, group = os.getuid(), os.getgid()
    system = ctypes.CDLL(None, use_errno=True)
    _require_success(system.unshare(_NEW))
    system.prctl(_DUMPABLE, 1, 0, 0, 0)  # otherwise the files below are not its own
    for name, text in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1"), ("gid_map", f"{group} {group} 1")):
        Path("/proc/self", name).write_text(text)
    if pid := os.fork():
        return int(pid)
    _require_success(system.mount(b"scratch", SCRATCH.encode(), b"tmpfs", _NOSUID | _NODEV, b"size=%d" % SIZE))
    system.mount(b"proc", b"/proc", b"proc", 0, None)  # refused where the sandbox hides parts of the one that is there
    system.prctl(_DUMPABLE, 0, 0, 0, 0)
    _require_success(system.capset((ctypes.c_uint32 * 2)(_CAPABILITIES, 0), (ctypes.c_uint32 * 6)()))
    return 0


def shares(own: int) -> bool:
    """Return whether this process holds memory, or more open files than its own, by which forks could reach others."""
    with open("/proc/self/maps") as maps:  # noqa: PTH123 - before every trial
        return len(os.listdir("/proc/self/fd")) > own + 2 or any(" rw-s " in line for line in maps)  # noqa: PTH208


def _require_success(result: int) -> None:
    if result:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


if __name__ == "__main__":  # whether processes can have namespaces of their own here
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) if (pid := enter()) else 0)
