"""bench solve: run one optimizer once on one problem."""

from __future__ import annotations

import sys
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.cli import completion
from bench.cli.console import Constraints, Parameters, ProblemParameters
from bench.errors import BenchError, ProblemError
from bench.helpers.console import pairs, print_error


def command(
    problem: Annotated[
        str,
        typer.Argument(
            help="A problem's name, such as signature-12 or recording:joint2.csv.", autocompletion=completion.problems
        ),
    ],
    optimizer: Annotated[
        str, typer.Argument(help="An optimizer's name, such as gwo.", autocompletion=completion.optimizers)
    ],
    budget: Annotated[str, typer.Option(help="Evaluations to spend: a number, or such as '1e4 * d'.")] = "60000",
    seed: Annotated[
        int, typer.Option(help="Seed of the run; with the seed in a study's row it repeats that trial.")
    ] = 0,
    option: Parameters = None,
    problem_option: ProblemParameters = None,
    constraints: Constraints = None,
    on_error: Annotated[
        str, typer.Option(metavar="fail|worst", help="With worst, a point at which the problem raises is worth +inf.")
    ] = "fail",
) -> None:
    """Run one optimizer once on one problem and print its best point."""
    from bench.execution.solve import solve
    from bench.plugins import loading
    from bench.scoring.constraints import DEFAULT
    from bench.study.budget import checked, evaluations

    loaded = loading.load_problem(problem, **pairs(problem_option))
    chosen = loading.load_optimizer(optimizer, **pairs(option))
    spent = evaluations(checked(budget, "--budget"), loaded.dimension)
    chosen.check_budget(spent, optimizer)
    try:
        result = solve(loaded, chosen, budget=spent, seed=seed, constraints=constraints or DEFAULT, on_error=on_error)
    except BenchError:
        raise
    except ProblemError as error:
        print_error(f"{problem} failed: {error}")
        sys.exit(1)
    except Exception as error:  # a plug-in may raise anything
        print_error(f"{optimizer} failed on {problem}: {type(error).__name__}: {error}")
        sys.exit(1)
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("best value, without noise" if loaded.noisy else "best value", repr(result.fun))
    for name, value in zip(loaded.variables, result.x, strict=True):
        table.add_row(Text(f"  {name}"), f"{value:.10g}")
    for name, value in result.metrics.items():
        table.add_row(Text(name), f"{value:.6g}")
    table.add_row("evaluations", f"{result.nfev} (stopped by: {result.stop})")
    times = f"{result.objective_time:.3f} s in the objective and {result.overhead_time:.3f} s in the optimizer"
    table.add_row("time", times)
    Console().print(table)
