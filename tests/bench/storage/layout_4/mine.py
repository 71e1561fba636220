"""An optimizer in a file, whose step is in a module beside it."""

from dataclasses import dataclass

from step import STEP

from bench import Optimizer


@dataclass(frozen=True)
class Hops(Optimizer):
    """Random hops around the best point."""

    def minimize(self, objective, rng):
        x = objective.initial(1)
        f = objective(x)
        while True:
            y = objective.repair(x + STEP * rng.standard_normal(x.shape))
            g = objective(y)
            if g[0] <= f[0]:
                x, f = y, g
