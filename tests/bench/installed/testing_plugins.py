"""Plug-ins for the tests of the harness; the folder beside this file registers them as an installed package does."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from time import sleep

import numpy as np

from bench import FunctionProblem, Optimizer, parameter


@dataclass(frozen=True)
class HillClimber(Optimizer):
    """A (1+1)-ES with the one-fifth rule (Rechenberg 1973)."""

    sigma: float = 0.2

    def minimize(self, objective, rng):
        span, step = objective.upper - objective.lower, self.sigma
        x = objective.initial(1)
        f = objective(x)
        while True:
            y = objective.repair(x + step * span * rng.standard_normal(x.shape))
            g = objective(y)
            if g <= f:
                x, f, step = y, g, step * 1.5
            else:
                step *= 1.5**-0.25


@dataclass(frozen=True)
class Scatter(Optimizer):
    """Uniform points, ``agents`` at a time."""

    agents: int = parameter(10, minimum=2)

    def minimize(self, objective, rng):
        while True:
            objective(rng.uniform(objective.lower, objective.upper, (self.agents, objective.dimension)))


@dataclass(frozen=True)
class Faulty(Optimizer):
    """Raises on every problem whose box is two-dimensional."""

    def minimize(self, objective, rng):
        objective(objective.initial(3))
        if objective.dimension == 2:
            raise RuntimeError("cannot do planes")
        while True:
            objective(objective.initial(3))


@dataclass(frozen=True)
class Early(Optimizer):
    """Stops after five evaluations, saying so or not."""

    honest: bool = True

    def minimize(self, objective, rng):
        objective(objective.initial(5))
        if self.honest:
            objective.stop("tired")


def pause():
    """Wait until the file $GATE exists, until workers with one core and with more have met in $MEETING, and $SLOW s."""
    gate, meeting = os.environ.get("GATE"), os.environ.get("MEETING")
    while gate and not Path(gate).exists():
        sleep(0.01)
    if meeting:
        one, more = Path(meeting, "one"), Path(meeting, "more")  # no listing, which would be an input
        (one if len(os.sched_getaffinity(0)) == 1 else more).touch()
        while not (one.exists() and more.exists()):
            sleep(0.01)
    sleep(float(os.environ.get("SLOW", "0.01")))


class Functions:
    """Spheres, a slow one, and some that break the contract, each in its own way."""

    def names(self):
        kinds = "sphere-2 sphere-3 slow-2 names-3 figures-2 text-2 exit-2 minus-2 death-2 ring-2"
        return kinds.split()

    def load(self, name, **options):
        kind, d = name.split("-")
        values = {
            "slow": lambda x: pause() or (x**2).sum(axis=1),
            "exit": lambda x: sys.exit(3),
            "minus": lambda x: np.full(len(x), -np.inf),
            "death": lambda x: os._exit(1),
        }
        box = [-5.0] * int(d), [5.0] * int(d)
        options = {"optimum": 0.0, "violations": None}
        if kind == "ring":  # outside a circle about the centre
            options = {"optimum": 9.0, "violations": lambda x: 9.0 - (x**2).sum(axis=1, keepdims=True)}
        problem = FunctionProblem(values.get(kind, lambda x: (x**2).sum(axis=1)), *box, name=name, **options)
        figures = {"figures": lambda x: {"fun": 1.0}, "text": lambda x: {"radius": "wide"}}
        problem.describe = figures.get(kind, lambda x: {"radius": float(np.linalg.norm(x))})
        if kind == "names":
            problem.variables = ("a", "a", "b")
        return problem


functions = Functions()
