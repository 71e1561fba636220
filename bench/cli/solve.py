"""bench solve: run one optimizer once on one problem."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from typing import Annotated, Any

import typer
from rich.console import Console

from bench.cli.console import Parameters, Untrusted, table
from bench.contract.typing import Floats, Options
from bench.helpers.console import pairs, print_error
from bench.helpers.errors import BenchError, ProblemError
from bench.helpers.text import said
from bench.plugins import loading
from bench.sandbox.messages import describe_error
from bench.study.budget import Budget
from bench.trial.columns import Row, named
from bench.trial.trial import as_row

Named = tuple[str, Options]  # a plug-in's name and its options


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
    option: Parameters = None,
    problem_option: Annotated[
        list[str] | None, typer.Option(help="An option of the problem, as in unit=rpm; repeatable.")
    ] = None,
    constraints: Annotated[
        str | None,
        typer.Option(help="What optimizers see of infeasible points: death, penalty, lexicographic or repair."),
    ] = None,
    on_error: Annotated[
        str, typer.Option(metavar="fail|worst", help="With worst, a point whose evaluation fails is worth +inf.")
    ] = "fail",
    evaluation_timeout: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help="How long the evaluation of a point may take, such as '30 s'."),
    ] = None,
    time: Annotated[
        str | None, typer.Option(metavar="DURATION", help="End the run after it, before its budget, such as '10 min'.")
    ] = None,
    initial: Annotated[
        str | None, typer.Option(metavar="FILE", help="A CSV file of points that are known, to begin with them.")
    ] = None,
    final_target: Annotated[
        float | None, typer.Option(help="End the run at this difference to the known optimum, such as 1e-8.")
    ] = None,
    stop_at: Annotated[
        float | None, typer.Option(help="End the run once a feasible point has this value, or a lower one.")
    ] = None,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", help="Folder in which evaluations are noted, to go on after an interruption."),
    ] = None,
    parallel: Annotated[
        int | None, typer.Option(help="Points of a call of the objective that are evaluated at a time, by processes.")
    ] = None,
    untrusted: Untrusted = False,
) -> None:
    """Run one optimizer once on one problem and print its best point."""
    if untrusted and output:
        raise BenchError("with --untrusted no --output is written: evaluations are noted by the code that is run")
    given = {
        "evaluation_timeout": evaluation_timeout, "time": time, "initial": initial, "output": output,
        "final_target": final_target, "stop_at": stop_at, "parallel": parallel, "constraints": constraints,
    }  # fmt: skip
    make = _row_apart if untrusted else _row
    row = make(
        (problem, pairs(problem_option)), (optimizer, pairs(option)), Budget.read(budget, "--budget"), seed=seed,
        on_error=on_error, **{key: value for key, value in given.items() if value is not None},
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
        print_error("interrupted" + "; the same command goes on from here" * (output is not None))
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
