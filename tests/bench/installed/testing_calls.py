"""What the tests of a process ask it for."""

import ctypes
import json
import os
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path

from bench.sandbox import server
from bench.sandbox.channel import _HEAD
from bench.sandbox.side_effects import SideEffects

loaded = []


def echo(*arguments):
    return arguments


def evaluate(expression):
    return eval(expression)


def load(word):
    """Change this module; return all words that were loaded."""
    loaded.append(word)
    return loaded


def load_once(word, path):
    """Hang where the file shows that it was called before."""
    if Path(path).exists():
        time.sleep(600)
    Path(path).touch()
    loaded.append(word)


def sleep(seconds):
    time.sleep(seconds)


def wait(path):
    """Return once the file exists."""
    while not Path(path).exists():
        time.sleep(0.01)


def work(path):
    """Send notes until the file exists; return the number sent."""
    sent = 0
    while not Path(path).exists():
        sent += 1
        server.note(sent)
    return sent


def hang_in_native_code(path):
    Path(path).write_text(f"{os.getpid()}\n")
    ctypes.PyDLL(None).pause()  # which never lets go of the interpreter


def hang_with_a_child(path):
    child = subprocess.Popen(["sleep", "60"])
    Path(path).write_text(f"{os.getpid()} {child.pid}\n")
    time.sleep(60)


def crash():
    ctypes.string_at(0)


def leave(code, words):
    os.write(2, words)
    os._exit(code)


def fork():
    pid = os.fork()
    if pid == 0:
        server.note("the fork's")
        return "the fork's"
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def fork_and_leave(path, own_session):
    """Start a child that writes its number into the file, and leave when it has."""
    if os.fork() == 0:
        if own_session:
            os.setsid()
        Path(path).write_text(f"{os.getpid()}\n")
        time.sleep(60)
        os._exit(0)
    while not (Path(path).exists() and Path(path).read_text()):
        time.sleep(0.01)
    os._exit(3)


def start_others():
    """Start a process with a session of its own, and one that nobody is the parent of."""
    own = subprocess.Popen(["sleep", "60"], start_new_session=True)
    orphan = "import subprocess; print(subprocess.Popen(['sleep', '60'], start_new_session=True, stdout=-3).pid)"
    return own.pid, int(subprocess.check_output([sys.executable, "-c", orphan]))


def start_threads(number):
    for _ in range(number):
        threading.Thread(target=time.sleep, args=(600,), daemon=True).start()


def hog(megabytes):
    held = b"x" * (megabytes * 1_000_000)
    time.sleep(60)
    return len(held)


def have_a_child_hog(megabytes):
    subprocess.run([sys.executable, "-c", f"import time; held = b'x' * {megabytes * 1_000_000}; time.sleep(60)"])


def print_much(megabytes):
    for _ in range(megabytes):
        for stream in (1, 2):
            os.write(stream, b"x" * 999_999 + b"\n")
    print("in Python too")
    return "done"


def lose_channel():
    os.closerange(3, 1 << 20)
    time.sleep(60)


class RaisingError(Exception):
    def __str__(self):
        raise ValueError("no")


class ColouredError(Exception):
    def __str__(self):
        return "\x1b[31mred\x00\tend\nsecond line"


def raise_(error):
    raise eval(error)


class Bomb:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (self.path, "w")


def send(payload, ahead=0):
    """Send a message as the answer to this call, or to one of the calls after it; then answer "honest"."""
    serving = server._serving
    serving._channel.send(serving._number + ahead, payload)
    return "honest"


def send_bomb(path):
    return send(pickle.dumps(("value", Bomb(path))))


def send_head(length):
    """Announce a message and do not send it."""
    server._serving._channel._end.send(_HEAD.pack(server._serving._number, length))
    time.sleep(600)


def send_files(number):
    """Send open files beside a message."""
    import socket

    end = socket.socket(fileno=os.dup(server._serving._channel.fileno()))
    payload = json.dumps(["note", None]).encode()
    for _ in range(number):
        socket.send_fds(end, [_HEAD.pack(server._serving._number, len(payload)) + payload], [0])


def side_effects(statement):
    """Return what a statement leaves behind, by name."""
    effects = SideEffects()
    with effects:
        exec(statement, {})
    return {"random": effects.random, "threads": effects.threads, "processes": effects.processes,
            "altered": effects.altered, "any": effects.any}  # fmt: skip
