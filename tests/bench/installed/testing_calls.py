"""What the tests of a process ask it for."""

import ctypes
import os
import subprocess
import sys
import time
from pathlib import Path


def echo(*arguments, pulse):
    return arguments


def evaluate(expression, pulse):
    return eval(expression)


def sleep(seconds, pulse):
    pulse(1, 2)
    time.sleep(seconds)


def work(path, pulse):
    """Pulse until the file exists; return how many pulses were sent."""
    sent = 0
    while not Path(path).exists():
        pulse(1, 2)
        sent += 1
    return sent


def hang_in_native_code(path, pulse):
    Path(path).write_text(f"{os.getpid()}\n")
    ctypes.PyDLL(None).pause()  # which never lets go of the interpreter


def hang_with_a_child(path, pulse):
    child = subprocess.Popen(["sleep", "60"])
    Path(path).write_text(f"{os.getpid()} {child.pid}\n")
    time.sleep(60)


def crash(pulse):
    ctypes.string_at(0)


def leave(code, words, pulse):
    os.write(2, words)
    os._exit(code)


def fork(pulse):
    pid = os.fork()
    if pid == 0:
        pulse(7, 7)
        return "the fork's"
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def fork_and_leave(path, own_session, seen, pulse):
    """Start a child that writes its number into the file, and leave when the child is seen: when that file exists."""
    if os.fork() == 0:
        if own_session:
            os.setsid()
        Path(path).write_text(f"{os.getpid()}\n")
        time.sleep(60)
        os._exit(0)
    while not (Path(path).exists() and Path(seen).exists()):
        time.sleep(0.01)
    os._exit(3)


def start_others(pulse):
    """Start a process with a session of its own, and one that nobody is the parent of."""
    own = subprocess.Popen(["sleep", "60"], start_new_session=True)
    orphan = "import subprocess; print(subprocess.Popen(['sleep', '60'], start_new_session=True, stdout=-3).pid)"
    return own.pid, int(subprocess.check_output([sys.executable, "-c", orphan]))


def hog(megabytes, pulse):
    held = b"x" * (megabytes * 1_000_000)
    time.sleep(60)
    return len(held)


def have_a_child_hog(megabytes, pulse):
    subprocess.run([sys.executable, "-c", f"import time; held = b'x' * {megabytes * 1_000_000}; time.sleep(60)"])


def print_much(megabytes, pulse):
    for _ in range(megabytes):
        for stream in (1, 2):
            os.write(stream, b"x" * 999_999 + b"\n")
    print("in Python too")
    return "done"


def lose_pipes(pulse):
    time.sleep(0.1)  # the next call is waited for
    os.closerange(3, 100)
    time.sleep(60)


class RaisingError(Exception):
    def __str__(self):
        raise ValueError("no")


class ColouredError(Exception):
    def __str__(self):
        return "\x1b[31mred\x00\tend\nsecond line"


def raise_(error, pulse):
    raise eval(error)


class Reluctant:
    """Its copy cannot be made."""

    def __reduce__(self):
        return int, ("not a number",)
