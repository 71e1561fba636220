"""Optimizers that were made to have one bias each, and one that has none."""

import json
import os
from dataclasses import dataclass

import numpy as np

from bench import Optimizer, parameter


@dataclass(frozen=True)
class Chains(Optimizer):
    """Hill climbers side by side on a torus, where no place differs from another."""

    agents: int = parameter(20, minimum=1)

    def start(self, objective, rng):
        return objective.initial(self.agents)

    def confine(self, objective, x):
        return objective.lower + np.mod(x - objective.lower, objective.upper - objective.lower)

    def minimize(self, objective, rng):
        span, step = objective.upper - objective.lower, np.full((self.agents, 1), 0.2)
        x = self.start(objective, rng)
        f = objective(x)
        while True:
            y = self.confine(objective, x + step * span * rng.standard_normal(x.shape))
            g = objective(y)
            better = g <= f
            x, f = np.where(better[:, None], y, x), np.where(better, g, f)
            step *= np.where(better, 1.5, 1.5**-0.25)[:, None]


@dataclass(frozen=True)
class Shrinking(Chains):
    """Draws ever closer to the centre, whatever it sees."""

    def confine(self, objective, x):
        middle = (objective.lower + objective.upper) / 2
        return middle + 0.5 * (super().confine(objective, x) - middle)


@dataclass(frozen=True)
class Clipping(Chains):
    """Takes what leaves the box back to its bound."""

    def confine(self, objective, x):
        return objective.repair(x)


@dataclass(frozen=True)
class Cornered(Chains):
    """Starts in the lower half of the box."""

    def start(self, objective, rng):
        return objective.lower + 0.5 * (super().start(objective, rng) - objective.lower)


@dataclass(frozen=True)
class Numbered(Chains):
    """Starts where the number of its seed puts it."""

    def start(self, objective, rng):
        place = rng.bit_generator.seed_seq.entropy % 1000 / 1000
        return objective.lower + (objective.upper - objective.lower) * np.full(
            (self.agents, objective.dimension), place
        )


@dataclass(frozen=True)
class Constant(Chains):
    """Starts with the same points in every run."""

    def start(self, objective, rng):
        return np.random.default_rng(0).uniform(objective.lower, objective.upper, (self.agents, objective.dimension))


@dataclass(frozen=True)
class Deterministic(Constant):
    """Does the same in every run."""

    def minimize(self, objective, rng):
        super().minimize(objective, np.random.default_rng(0))


@dataclass(frozen=True)
class Raising(Optimizer):
    """Fails at once."""

    def minimize(self, objective, rng):
        raise ZeroDivisionError("boom")


@dataclass(frozen=True)
class Exiting(Optimizer):
    """Takes its process along."""

    def minimize(self, objective, rng):
        os._exit(1)


class InThisProcess:
    """Makes every call here, which spares the start of processes, and passes its answer on as JSON."""

    def __init__(self, n_jobs, ready, sandbox=None):
        ready()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def answers(self, calls):
        for call in calls:
            yield call, json.loads(json.dumps(call.function(*call.arguments)))


SHORT = {"functions": ("sphere",), "function_budget": 2_000}
LITTLE = SHORT | {"callers": InThisProcess, "n_jobs": 1}
