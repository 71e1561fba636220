"""Sound optimizers, and optimizers with one defect each."""

import itertools
import time
from dataclasses import dataclass

import numpy as np

from bench import AskTell, Optimizer, parameter


@dataclass(frozen=True)
class Swarm(Optimizer):
    """Particles that follow their own best points and the best of all (Kennedy and Eberhart 1995)."""

    agents: int = parameter(20, minimum=2)
    inertia: float = 0.72
    own: float = 1.49
    shared: float = 1.49

    def minimize(self, objective, rng):
        rng = self.generator(rng)
        x = objective.initial(self.number())
        f = objective(x)
        v, best, best_f, leader = np.zeros_like(x), x.copy(), f.copy(), (x[f.argmin()].copy(), f.min())
        for generation in itertools.count(1):
            own, shared = rng.random((2, *x.shape))
            v = self.inertia * v + self.own * own * (best - x) + self.shared * shared * (leader[0] - x)
            x = objective.repair(np.clip(x + v, objective.lower, objective.upper))
            f = objective(x)
            better = f < best_f
            best[better], best_f[better] = x[better], f[better]
            leader = self.follow(leader, x, f, generation)

    def generator(self, rng):
        return rng

    def number(self):
        return self.agents

    def follow(self, leader, x, f, generation):
        return (x[f.argmin()].copy(), f.min()) if f.min() < leader[1] else leader


@dataclass(frozen=True)
class Wolves(Optimizer):
    """A pack that gathers around its three best points (Mirjalili 2014)."""

    agents: int = parameter(20, minimum=3)

    def minimize(self, objective, rng):
        x = objective.initial(self.agents)
        leaders, values = [x[i].copy() for i in range(3)], [np.inf] * 3
        generations = max(1, objective.budget // self.agents)
        for generation in itertools.count():
            for i, value in enumerate(objective(x)):
                place = sum(value >= known for known in values)
                if place < 3:
                    leaders.insert(place, self.kept(x, i))
                    values.insert(place, value)
                    del leaders[3:], values[3:]
            a = 2 - 2 * min(1, generation / generations)
            for i in range(len(x)):
                to = []
                for leader in leaders:
                    r, s = rng.random((2, len(leader)))
                    to.append(leader - (2 * a * r - a) * abs(2 * s * leader - x[i]))
                x[i] = objective.repair(np.clip(np.mean(to, axis=0), objective.lower, objective.upper)[None])[0]

    def kept(self, x, i):
        return x[i].copy()


@dataclass(frozen=True)
class Evolution(Optimizer):
    """DE/rand/1/bin (Storn and Price 1997)."""

    agents: int = parameter(20, minimum=4)
    weight: float = 0.6
    crossover: float = 0.9

    def minimize(self, objective, rng):
        x = objective.initial(self.agents)
        f = objective(x)
        while True:
            a, b, c = (x[rng.permutation(self.agents)] for _ in range(3))
            mixed = rng.random(x.shape) < self.crossover
            y = np.where(mixed, a + self.weight * (b - c), x)
            y = objective.repair(np.clip(y, objective.lower, objective.upper))
            g = objective(y)
            better = g < f
            x[better] = y[better]
            f = self.values(f, g, better)

    def values(self, f, g, better):
        return np.where(better, g, f)


@dataclass(frozen=True)
class Annealing(Optimizer):
    """A walk that accepts what is worse more rarely as it cools (Kirkpatrick 1983)."""

    step: float = 0.2
    cooling: float = 0.97

    def minimize(self, objective, rng):
        x = objective.initial(1)[0]
        f, span = objective(x), objective.upper - objective.lower
        began = time.monotonic()
        for move in itertools.count():
            heat = self.heat(move, began)
            y = objective.repair((x + self.step * span * rng.standard_normal(len(x)))[None])[0]
            g = objective(y)
            if g < f or rng.random() < np.exp(-(g - f) / max(1e-300, heat)):
                x, f = y, g

    def heat(self, move, began):
        return self.cooling**move


@dataclass(frozen=True)
class HookeJeeves(Optimizer):
    """Steps along the coordinates, halved where none is better (Hooke and Jeeves 1961)."""

    def minimize(self, objective, rng):
        while True:
            x = objective.initial(1)[0]
            f, step = objective(x), 0.25 * (objective.upper - objective.lower)
            while (step > 1e-9 * (objective.upper - objective.lower)).any():
                before = f
                for k, sign in itertools.product(range(len(x)), (1, -1)):
                    y = x.copy()
                    y[k] += sign * step[k]
                    y = objective.repair(y[None])[0]
                    if (g := objective(y)) < f:
                        x, f = y, g
                if f == before:
                    step = step / 2


@dataclass(frozen=True)
class CommaStrategy(Optimizer):
    """A (3, 12)-ES, which keeps no point."""

    def minimize(self, objective, rng):
        mean, sigma = objective.initial(1)[0], 0.3
        while True:
            x = mean + sigma * (objective.upper - objective.lower) * rng.standard_normal((12, len(mean)))
            x = objective.repair(np.clip(x, objective.lower, objective.upper))
            mean, sigma = x[objective(x).argsort(kind="stable")[:3]].mean(axis=0), 0.9 * sigma


@dataclass(frozen=True)
class Chains(Optimizer):
    """Eight climbers that know nothing of each other."""

    agents: int = parameter(8, minimum=1)

    def minimize(self, objective, rng):
        x = objective.initial(self.agents)
        f, span = objective(x), objective.upper - objective.lower
        while True:
            y = objective.repair(x + 0.1 * span * rng.standard_normal(x.shape))
            g = objective(y)
            x, f = np.where((g < f)[:, None], y, x), np.minimum(f, g)


class Around:
    """Draws around the best point so far."""

    def __init__(self, objective, rng, step):
        self.objective, self.rng, self.step = objective, rng, step
        self.best, self.value = None, np.inf

    def ask(self, n):
        if self.best is None:
            return self.objective.initial(n)
        span = self.objective.upper - self.objective.lower
        return self.objective.repair(self.best + self.step * span * self.rng.standard_normal((n, len(span))))

    def tell(self, x, f):
        if self.best is None or f.min() < self.value:
            self.best, self.value = x[f.argmin()].copy(), f.min()


@dataclass(frozen=True)
class Asked(AskTell):
    """A (1+10)-ES that is asked and told."""

    agents: int = parameter(10, minimum=1)
    step: float = 0.1

    def start(self, objective, rng):
        return Around(objective, rng, self.step)


# --- ten defects ---


@dataclass(frozen=True)
class FixedGenerator(Swarm):
    """Moves by a generator of its own."""

    def generator(self, rng):
        return np.random.default_rng(7)


@dataclass(frozen=True)
class OneMore(Swarm):
    """Has one particle more than it says."""

    def number(self):
        return self.agents + 1


@dataclass(frozen=True)
class StaleLeader(Swarm):
    """Follows the best point of the first generation."""

    def follow(self, leader, x, f, generation):
        return leader


@dataclass(frozen=True)
class LateLeader(Swarm):
    """Looks for the best point every tenth generation."""

    def follow(self, leader, x, f, generation):
        return super().follow(leader, x, f, generation) if generation % 10 == 0 else leader


@dataclass(frozen=True)
class Seconds(Swarm):
    """Takes a seed from the clock, in seconds, so that runs of the same second are equal."""

    def generator(self, rng):
        return np.random.default_rng([int(time.time()), int(rng.integers(2**31))])


@dataclass(frozen=True)
class Deadline(Swarm):
    """Moves otherwise after a minute."""

    def minimize(self, objective, rng):
        object.__setattr__(self, "began", time.perf_counter())
        super().minimize(objective, rng)

    def follow(self, leader, x, f, generation):
        slow = time.perf_counter() - self.began > 60
        return (x[-1].copy(), f[-1]) if slow else super().follow(leader, x, f, generation)


# --- new ones, written before they were run ---


@dataclass(frozen=True)
class DriftingLeaders(Wolves):
    """Keeps the rows of the leaders, which move on, in place of copies."""

    def kept(self, x, i):
        return x[i]


@dataclass(frozen=True)
class LostBest(Swarm):
    """Has the particles' own best points follow the particles: nothing is copied."""

    def minimize(self, objective, rng):
        x = objective.initial(self.agents)
        f = objective(x)
        best, leader, v = x, (x[f.argmin()].copy(), f.min()), np.zeros_like(x)
        while True:
            own, shared = rng.random((2, *x.shape))
            v = self.inertia * v + self.own * own * (best - x) + self.shared * shared * (leader[0] - x)
            x += v
            x[:] = objective.repair(np.clip(x, objective.lower, objective.upper))
            f = objective(x)
            leader = self.follow(leader, x, f, 0)


@dataclass(frozen=True)
class CoolingClock(Annealing):
    """Cools by the clock."""

    def heat(self, move, began):
        return float(np.exp(-(time.monotonic() - began) / 600))


@dataclass(frozen=True)
class OldState(Swarm):
    """Moves by a generator of the old kind with the usual seed; draws from the trial's as well."""

    def generator(self, rng):
        rng.random()
        return np.random.RandomState(42)


@dataclass(frozen=True)
class ForgottenValues(Evolution):
    """Replaces points and not their values."""

    def values(self, f, g, better):
        return f
