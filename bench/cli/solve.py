"""bench solve: run one optimizer once on one problem."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.console import Console

from bench.cli.console import Parameters, Untrusted, table
from bench.contract.typing import Floats, Options
from bench.helpers.console import pairs, print_error
from bench.helpers.errors import BenchError, ProblemError
from bench.helpers.option_groups import OptionGroup, grouped, option
from bench.helpers.text import said
from bench.plugins import loading
from bench.sandbox.messages import describe_error
from bench.study.budget import Budget
from bench.trial.columns import Row, named
from bench.trial.trial import as_row

Named = tuple[str, Options]  # a plug-in's name and its options


class Settings(OptionGroup):
    """The settings of a run, by their names in ``bench.solve``."""

    constraints: str | None = option(
        help="What optimizers see of infeasible points: death, penalty, lexicographic or repair."
    )
    on_error: str = option(
        "fail", metavar="fail|worst", help="With worst, a point whose evaluation fails is worth +inf."
    )
    evaluation_timeout: str | None = option(
        metavar="DURATION", help="How long the evaluation of a point may take, such as '30 s'."
    )
    time: str | None = option(metavar="DURATION", help="End the run after it, before its budget, such as '10 min'.")
    initial: str | None = option(metavar="FILE", help="A CSV file of points that are known, to begin with them.")
    final_target: float | None = option(help="End the run at this difference to the known optimum, such as 1e-8.")
    stop_at: float | None = option(help="End the run once a feasible point has this value, or a lower one.")
    output: str | None = option(
        None, "--output", "-o", help="Folder in which evaluations are noted, to go on after an interruption."
    )
    parallel: int | None = option(help="Points of a call of the objective that are evaluated at a time, by processes.")


@grouped
def command(
    problem: Annotated[
        str,
        typer.Argument(help="A problem's name, such as signature-12 or recording:joint2.csv."),
    ],
    optimizer: Annotated[str, typer.Argument(help="An optimizer's name, such as gwo.")],
    budget: Annotated[str, typer.Option(help="Evaluations to spend: a number, or such as '1e4 * d'.")] = "60000",
    seed: Annotated[
        int, typer.Option(help="Seed of the run; with the seed in a study's row it repeats that trial.")
    ] = 0,
    parameters: Parameters = None,
    problem_option: Annotated[
        list[str] | None, typer.Option(help="An option of the problem, as in unit=rpm; repeatable.")
    ] = None,
    *,
    settings: Settings,
    untrusted: Untrusted = False,
) -> None:
    """Run one optimizer once on one problem and print its best point."""
    if untrusted and settings.output:
        raise BenchError("with --untrusted no --output is written: evaluations are noted by the code that is run")
    make = _row_apart if untrusted else _row
    row = make(
        (problem, pairs(problem_option)), (optimizer, pairs(parameters)), Budget.read(budget, "--budget"), seed=seed,
        **{name: value for name, value in asdict(settings).items() if value is not None},
    )  # fmt: skip
    if row["status"] != "ok":
        print_error(row["error"] if row.get("problem") else f"{optimizer} failed on {problem}: {row['error']}")
        sys.exit(1)
    objective = row["objective_s"]
    rows = [
        ("best value, without noise" if row.get("noisy") else "best value", repr(row["fun"])),
        *((f"  {name}", f"{value:.10g}") for name, value in named(row, "x").items()),
        *((name, f"{value:.6g}") for name, value in named(row, "metrics").items()),
        ("evaluations", f"{row['nfev']} (stopped by: {row['stop']})"),
        ("time", f"{objective:.3f} s in the objective and {row['wall_s'] - objective:.3f} s in the optimizer"),
    ]
    Console().print(table(("", ""), rows))
    if row["stop"] == "interrupted":
        print_error("interrupted" + "; the same command goes on from here" * (settings.output is not None))
        sys.exit(130)
    if row["stop"] == "undeclared":
        print_error(
            f"{optimizer} returned before the budget was spent and declared no reason: loop until the budget ends the "
            'run, or call objective.stop("reason")'
        )
        sys.exit(1)


def _row(problem: Named, optimizer: Named, budget: Budget, **settings: Any) -> Row:
    """Return the row of a run in this process, and whether the problem is ``noisy``."""
    from bench.execution.solve import solve, warm

    loaded = loading.load_problem(problem[0], **problem[1])
    chosen = loading.load_optimizer(optimizer[0], **optimizer[1])
    spent = budget.evaluations(loaded.dimension)
    chosen.check_budget(spent, optimizer[0])
    if not loading.brings_code(optimizer[0]):
        warm(loaded, chosen, spent)
    try:
        with Console().status("") if "output" in settings else nullcontext() as shown:

            def show(number: int, x: Floats, f: float, best: float) -> None:  # noqa: ARG001
                if shown is not None:
                    shown.update(f"{number:,} of {spent:,} evaluations, best value {best!r}")

            try:
                found = solve(loaded, chosen, budget=spent, on_evaluation=show if shown else None, **settings)
            except KeyboardInterrupt as interrupt:
                if "found" not in vars(interrupt):
                    raise
                found = vars(interrupt)["found"]
        return as_row(found, tuple(map(said, loaded.variables))) | {"noisy": loaded.noisy}
    except BenchError:
        raise
    except ProblemError as error:
        return {"status": "failed", "problem": True, "error": f"{problem[0]} failed: {describe_error(error.raised)}"}
    except Exception as error:  # a plug-in may raise anything
        return {"status": "failed", "error": describe_error(error)}


def _row_apart(problem: Named, optimizer: Named, budget: Budget, **settings: Any) -> Row:
    """Return the row of a run of code that nobody trusts."""
    from bench.execution.solve import solve_untrusted

    about, chosen = ({"name": name, **options} for name, options in (problem, optimizer))
    if "initial" in settings:
        about["initial"] = settings.pop("initial")
    return solve_untrusted(about, chosen, budget=budget, **settings)
