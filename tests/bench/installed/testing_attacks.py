"""Optimizers that change what others share in memory, or end the processes that made them."""

import ctypes
import os
import signal
import sys
import time
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import psutil

import bench.execution.trial_process
import bench.study
import bench.trial.trial
from bench import Optimizer
from bench.helpers.errors import BudgetExhausted

UPWARD = 0x800  # FE_UPWARD (fenv.h, x86)


def scatter(objective):
    with suppress(BudgetExhausted):
        while True:
            objective(objective.initial(5))


def trial():
    """Return the trial under way, from the frame of the function that makes it; None in a warm-up."""
    frame = sys._getframe()
    while frame := frame.f_back:
        if frame.f_code.co_name == "make":
            return frame.f_locals["trial"]
    return None


def once():
    """Whether this is the one trial in which attacks are made that end processes, which takes seconds."""
    made = trial()
    return made and (made.problem, made.number) == ("sphere-3", 0)


# What others share in memory


def replace_gwo(objective):
    from optimizers.gwo import GWO

    GWO.minimize = lambda self, objective, rng: None


def replace_evaluate(objective):
    type(objective._problem).evaluate = lambda self, x: np.zeros(len(x))


def replace_kernel(objective):
    from problems.backlash.signature import kernel

    kernel.evaluate = lambda x, folded: np.zeros(len(x))
    kernel.repair = lambda x, *_: x


def replace_search(objective):
    def search(problem, optimizer, budget, seed, on_refusal=None):
        found = original(problem, optimizer, budget, seed, on_refusal)
        return found if trial() is None else bench.trial.trial.Result(**(vars(found) | {"fun": 0.0}))

    original = bench.trial.trial.search
    bench.trial.trial.search = bench.execution.trial_process.search = search


def replace_study(objective):
    bench.study.Study.optimizer = lambda self, label: Attack("scatter")


def zero_signal(objective):
    for held in vars(objective._problem).values():
        for each in held if isinstance(held, tuple) else (held,):
            if isinstance(each, np.ndarray):
                each.flags.writeable = True
                each[...] = 0.0


def round_upward(objective):
    ctypes.CDLL(None).fesetround(UPWARD)


# Who made it


def ancestors():
    """Return the processes of the job that led to this one, from its own template to the root."""
    return [each.pid for each in psutil.Process().parents() if "bench.sandbox.server" in " ".join(each.cmdline())]


def signals(number, choose):
    def do(objective):
        if once():
            for pid in choose(ancestors()):
                os.kill(pid, number)
            time.sleep(0.1)

    return do


def kill_main(objective):
    if trial():
        os.kill(psutil.Process(ancestors()[-1]).ppid(), signal.SIGKILL)


DEEDS = {
    "scatter": lambda objective: None,
    "replace-gwo": replace_gwo,
    "replace-evaluate": replace_evaluate,
    "replace-kernel": replace_kernel,
    "replace-search": replace_search,
    "replace-study": replace_study,
    "zero-signal": zero_signal,
    "round-upward": round_upward,
    "kill-parent": signals(signal.SIGKILL, lambda pids: pids[:1]),
    "kill-all": signals(signal.SIGKILL, lambda pids: pids[::-1]),
    "kill-main": kill_main,
}


@dataclass(frozen=True)
class Attack(Optimizer):
    """Does one deed, also in its warm-up, and then samples at random."""

    deed: str = "scatter"

    def minimize(self, objective, rng):
        DEEDS[self.deed](objective)
        scatter(objective)
