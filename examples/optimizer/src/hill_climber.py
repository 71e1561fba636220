"""An optimizer that anybody can install beside backlash-bench."""

from dataclasses import dataclass

from bench import Optimizer


@dataclass(frozen=True)
class HillClimber(Optimizer):
    """A (1+1)-ES with the one-fifth rule (Rechenberg 1973)."""

    sigma: float = 0.2  # initial step, as a fraction of the box

    def minimize(self, objective, rng):
        span, step = objective.upper - objective.lower, self.sigma
        x = objective.initial(1)
        f = objective(x)
        while True:  # the budget ends it
            y = objective.repair(x + step * span * rng.standard_normal(x.shape))
            g = objective(y)
            if g <= f:
                x, f, step = y, g, step * 1.5
            else:
                step *= 1.5**-0.25
