"""Optimizers that do in planes what no optimizer should, and sample at random elsewhere."""

import builtins
import ctypes
import gc
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench import Optimizer
from bench.helpers.errors import BudgetExhausted

ESCAPES = "\x1b[31m\x1b]0;title\x07\u202ered"


class UnspeakableError(Exception):
    def __str__(self):
        raise SystemExit


def scatter(objective, rng):
    while True:
        objective(rng.uniform(objective.lower, objective.upper, (10, objective.dimension)))


def raises(error):
    def do(objective, rng):
        raise error

    return do


def spin():
    while True:
        pass


def hang_in_native_code(objective, rng):
    ctypes.PyDLL(None).sleep(1000)  # keeps the interpreter's lock


def swallow(objective, rng):
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    while True:
        try:
            while True:
                time.sleep(0.1)
        except BaseException:
            continue


def ask_for_ever(objective, rng):
    while True:
        try:
            scatter(objective, rng)
        except BudgetExhausted:
            continue


def allocate(objective, rng):
    held = bytearray(600_000_000)
    held[::4096] = bytes(len(held[::4096]))  # pages that are never written take no memory
    time.sleep(1000)


def kill(number):
    def do(objective, rng):
        os.kill(os.getpid(), number)
        scatter(objective, rng)

    return do


def kill_once(objective, rng):
    marker = Path(os.environ["MARKER"])
    if objective.remaining == objective.budget and objective.budget > 30 and not marker.exists():  # no warm-up
        marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    scatter(objective, rng)


def write_much(objective, rng):
    for _ in range(50):
        os.write(2, b"x" * 999_999 + b"\n")
    scatter(objective, rng)


def start_threads(objective, rng):
    for _ in range(2):
        threading.Thread(target=spin).start()
    scatter(objective, rng)


def fork_and_stay(objective, rng):
    if os.fork() == 0:
        os.setsid()
        time.sleep(1000)
    scatter(objective, rng)


def start_processes(objective, rng):
    subprocess.Popen(["sleep", "1000"], start_new_session=True)
    subprocess.run([sys.executable, "-Sc", "import subprocess; subprocess.Popen(['sleep', '1000'])"], check=True)
    scatter(objective, rng)


def then_scatter(*steps):
    """Change what the process has in common for all, and go on."""

    def do(objective, rng):
        for step in steps:
            step()
        scatter(objective, rng)

    return do


def change_the_process():
    os.environ.update(PATH="", HOSTILE="1")
    os.chdir("/")
    np.seterr(all="raise")
    warnings.simplefilter("error")
    gc.disable()
    sys.setrecursionlimit(100)
    sys.path = []
    sys.settrace(lambda *_: None)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    sys.stdout = sys.stderr = None


def patch():
    np.random.default_rng = lambda *_: None
    np.minimum = np.maximum
    builtins.float = int


def forget_modules():
    for name in [name for name in sys.modules if name.startswith(("numpy", "json", "bench"))]:
        del sys.modules[name]


def stop_with_megabytes(objective, rng):
    objective(objective.initial(1))
    objective.stop(ESCAPES + "<b>tired</b>\n" + "x" * 2_000_000)


DEEDS = {
    "raise": raises(ValueError(f"{ESCAPES}<script>alert(1)</script>\\input{{x}}" + "y" * 2_000_000)),
    "raise-exit": raises(SystemExit(0)),
    "raise-unspeakable": raises(UnspeakableError()),
    "native": hang_in_native_code,
    "swallow": swallow,
    "freeze": kill(signal.SIGSTOP),
    "ask-for-ever": ask_for_ever,
    "allocate": allocate,
    "crash": lambda objective, rng: ctypes.string_at(0),
    "kill": kill(signal.SIGKILL),
    "kill-once": kill_once,
    "write": write_much,
    "threads": start_threads,
    "fork-and-stay": fork_and_stay,
    "processes": start_processes,
    "change": then_scatter(change_the_process),
    "patch": then_scatter(patch),
    "forget": then_scatter(forget_modules),
    "close-files": then_scatter(lambda: os.closerange(0, 100)),
    "stop": stop_with_megabytes,
}


@dataclass(frozen=True)
class Hostile(Optimizer):
    """Does one deed."""

    deed: str = "raise"

    def minimize(self, objective, rng):
        return (DEEDS[self.deed] if objective.dimension == 2 else scatter)(objective, rng)
