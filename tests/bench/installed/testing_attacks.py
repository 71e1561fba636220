"""Optimizers that attack others, the harness or their own record: from memory, through the channel, by signals."""

import ctypes
import json
import os
import pickle
import signal
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

import bench.execution.trial_process
import bench.study
import bench.trial
from bench import Optimizer
from bench.objective import BudgetExhausted
from bench.sandbox import server

UPWARD = 0x800  # FE_UPWARD (fenv.h, x86)
SECONDS = {"wall_s": 0.0, "cpu_s": 0.0, "objective_s": 0.0}


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
    """Whether this is the one trial in which attacks are made that end or stop processes, which takes seconds."""
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
        return found if trial() is None else bench.trial.Result(**(vars(found) | {"fun": 0.0}))

    original = bench.trial.search
    bench.trial.search = bench.execution.trial_process.search = search


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


# What is sent in place of an answer


class Bomb:
    """Makes a file when it is unpickled."""

    def __reduce__(self):
        return Path.touch, (Path(os.environ["MARKER"]),)


def sends(payload, *, also_at_first=False):
    def do(objective):
        own = server._serving
        if trial() or also_at_first:
            own._channel.send(own._number, payload() if callable(payload) else json.dumps(payload).encode())

    return do


def note_for_ever(objective):
    while once():
        server.note(None)


# What is claimed


def claim_value(objective):
    scatter(objective)
    objective.best_value = 1e-12


def claim_trace(objective):
    scatter(objective)
    objective.best_value = objective._improved_to[-1] = 1e-12


def claim_budget(objective):
    objective(objective.initial(5))
    objective.stop("budget")
    raise BudgetExhausted


def raise_budget(objective):
    objective._budget = 10 * objective.budget


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
    "send-pickle": sends(lambda: pickle.dumps(Bomb()), also_at_first=True),
    "send-pickled-value": sends(lambda: pickle.dumps(["value", Bomb()])),
    "send-pair": sends(["answer", 5]),
    "send-number": sends(["value", 5]),
    "send-nothing": sends(["value", {}]),
    "send-text": sends(["value", {"nfev": 60, "outside_box": 0, "fun": "low"} | SECONDS]),
    "send-altered": sends(["value", {"altered": False, "error": 5}]),
    "notes": note_for_ever,
    "claim-value": claim_value,
    "claim-trace": claim_trace,
    "claim-budget": claim_budget,
    "raise-budget": raise_budget,
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
