"""Programs in any language, as ``command:./mine``: they propose points on standard output, in lines of JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bench.contract.families import derive
from bench.contract.objective import Objective
from bench.contract.optimizer import Optimizer, build, settings
from bench.contract.typing import Floats
from bench.helpers import Json, ProgramCommand, Talk, short
from bench.helpers.errors import BenchError, BudgetExhausted

PROTOCOL = 1
REQUEST = 'a line of JSON such as {"x": [[0.5, 0.5]]}, {"repair": [[…]]}, {"initial": 1} or {"stop": "converged"}'


@dataclass(frozen=True)
class Program(Optimizer):
    """A program that proposes points, and is started anew for each trial; its options are passed on to it."""

    code: ClassVar[str] = "a program"
    command: ClassVar[ProgramCommand]

    def minimize(self, objective: Objective, rng: np.random.Generator) -> None:
        """Answer what the program asks, by docs/reference/protocol.md; raises BenchError where it breaks the rules."""
        with Talk(self.command, REQUEST) as talk:
            talk.say(
                protocol=PROTOCOL,
                dimension=objective.dimension,
                lower=objective.lower.tolist(),
                upper=objective.upper.tolist(),
                integer=objective.integer.tolist(),
                budget=objective.budget,
                seed=int(rng.integers(1, 2**31 - 1)),
                options=settings(self),
            )
            try:
                while (request := talk.hear()) is not None:
                    match request:
                        case {"x": x, **rest} if not rest:
                            talk.say(f=objective(_points(x, objective.dimension, talk)).tolist())
                        case {"repair": x, **rest} if not rest:
                            talk.say(x=objective.repair(_points(x, objective.dimension, talk)).tolist())
                        case {"initial": int(n), **rest} if not rest and 1 <= n <= objective.budget:
                            talk.say(x=objective.initial(n).tolist())
                        case {"initial": int(n), **rest} if not rest and n > objective.budget:
                            most = f"at most {objective.budget:,}, the budget"
                            raise talk.error(f"asked for {n:,} initial points, which exceeds the budget", most)
                        case {"log": {**values}, **rest} if not rest:
                            _keep(values, objective, talk)
                        case {"stop": str(reason), **rest} if not rest:
                            return objective.stop(reason)
                        case _:
                            raise talk.error(f"wrote {short(request)}")
            except BudgetExhausted:
                talk.say(stop="budget")
                raise


def _keep(values: dict[Any, Json], objective: Objective, talk: Talk) -> None:
    """Log what a program says of its search; raises BenchError for what is no number."""
    try:
        objective.log(**values)
    except (TypeError, ValueError) as error:
        raise talk.error(f"logged {short(values)} ({error})", "at most 20 names of numbers") from None


def _points(value: object, dimension: int, talk: Talk) -> Floats:
    """Return the (n, d) points of a request; raises BenchError where they are none."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 2 or array.shape[1] != dimension or not len(array):
        raise talk.error(f"sent the points {short(value)}", f"a list of points, each of {dimension} numbers")
    return array


class Command:
    """The family ``command:<words of a command>``: any program, in any language, that proposes points in lines of JSON.

    It has no list of names: 'bench solve classical-sphere-d5-i1 command:./mine' runs the program ./mine, and
    'command:"Rscript mine.R"' a script. In a study, write name = "command" and command = ["Rscript", "mine.R"].
    The protocol is in docs/reference/protocol.md; examples/command has programs to copy.
    """

    def __reduce__(self) -> str:
        """Pickle by reference."""
        return "command"

    def names(self) -> list[str]:
        """Return no name: there is nothing to list."""
        return []

    def load(self, name: str, **options: object) -> Optimizer:
        """Return the optimizer that runs a command; raises BenchError where its program is not found.

        The words of the command are as in a shell. All options are the program's own.
        """
        command = ProgramCommand.read(name)
        try:
            json.dumps(options, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise BenchError(f"the options of {name!r} must be texts, numbers, lists or tables of these") from error
        made = derive(Program, name, {key: (Any, value) for key, value in options.items()}, self.load, command=command)
        return build(made, name, options)


command = Command()
