"""Run processes in a sandbox of bubblewrap (Linux): nothing to write to, no network, and no other process in sight."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from bench.errors import BenchError, nearest

SANDBOXES = ("bwrap",)

SCRATCH = "/dev/shm"
"""The only folder that can be written in a sandbox: a memory file system of its own, emptied after each trial."""

_SECONDS = 20.0  # for the sandbox to start


def command(sandbox: str) -> list[str]:
    """Return the words that run a program in a sandbox when they are put before its command line.

    Raises:
        BenchError: for an unknown sandbox, or one that is not installed or cannot be used here.
    """
    if sandbox not in SANDBOXES:
        raise BenchError(f"unknown sandbox {sandbox!r}{nearest(sandbox, SANDBOXES)}")
    program = shutil.which("bwrap")
    if program is None:
        raise BenchError(
            "--sandbox bwrap needs bubblewrap, which is not installed here; install it (on Debian: apt install "
            "bubblewrap), or run without a sandbox"
        )
    scratch = {"TMPDIR": SCRATCH, "NUMBA_CACHE_DIR": f"{SCRATCH}/numba", "MPLCONFIGDIR": f"{SCRATCH}/matplotlib"}
    words = [program, "--ro-bind", "/", "/", "--proc", "/proc"]
    words += ["--dev", "/dev", "--tmpfs", SCRATCH, "--remount-ro", "/dev"]
    words += ["--unshare-all", "--die-with-parent", "--cap-drop", "ALL"]
    for name, value in scratch.items():
        words += ["--setenv", name, value]
    words.append("--")
    try:
        tried = subprocess.run([*words, "true"], capture_output=True, text=True, timeout=_SECONDS, check=False)
        reason = tried.stderr.strip() if tried.returncode else ""
    except (OSError, subprocess.TimeoutExpired) as error:
        reason = str(error)
    if reason:
        raise BenchError(f"the sandbox cannot be used here: {reason.splitlines()[-1]}")
    return words


def empty_scratch() -> None:
    """Remove all that the scratch folder holds; called in the sandbox."""
    for each in Path(SCRATCH).iterdir():
        if each.is_dir() and not each.is_symlink():
            shutil.rmtree(each, ignore_errors=True)
        else:
            each.unlink(missing_ok=True)
