"""bench atlas: compare the implementations of methods that several libraries have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli.console import Jobs, table
from bench.helpers.console import print_line, steps
from bench.helpers.text import count
from bench.numbers import require_seed, require_whole


def command(
    file: Annotated[
        Path | None, typer.Argument(help="A table of methods; by default those of the installed packages.")
    ] = None,
    method: Annotated[list[str] | None, typer.Option(help="A method of the table; repeatable. Default: all.")] = None,
    trials: Annotated[int, typer.Option(help="Trials of each implementation on each of ten functions.")] = 20,
    budget: Annotated[int, typer.Option(help="Evaluations of a trial.")] = 2000,
    seed: Annotated[int, typer.Option(help="Seed of the trials.")] = 0,
    jobs: Jobs = -1,
    output: Annotated[Path, typer.Option("--output", "-o", help="The folder to write.")] = Path("atlas"),
) -> None:
    """Compare the implementations of each method that several libraries have, and write a page for each method.

    All run on ten functions in 5 dimensions, five of them with the optimum at the centre of the box. The pages show
    which implementations differ (exact Kolmogorov-Smirnov tests, adjusted by Holm's method over all of them, at 5%),
    which are drawn to the centre or to the bounds, and which parameters have no effect. A table of your own adds
    methods, or implementations of known ones. Times are in times.csv.
    """
    from bench.atlas import compare, methods, survey, write_atlas
    from bench.atlas.compare import findings
    from bench.atlas.write import check_output

    require_whole("--trials", trials, 2, 1000)
    require_whole("--budget", budget, 50, 10_000_000)
    require_seed("--seed", seed)
    check_output(output)
    chosen = methods(file, method or ())
    console = Console()
    with steps(console, "atlas") as on_progress:
        surveyed = survey(chosen, trials=trials, budget=budget, seed=seed, jobs=jobs, on_progress=on_progress)
        on_progress("comparing", 1, 1)
        comparison = compare(surveyed)
    page = write_atlas(comparison, chosen, output, trials=trials, budget=budget, seed=seed)
    rows = [
        (made.method, made.label, comparison.groups.get(made.key, "–"), "; ".join(findings(entry)))
        for entry in comparison.surveyed
        for made in [entry.implementation]
    ]
    console.print(table(("method", "implementation", "letter", "finding"), rows))
    print_line(
        f"{comparison.counted} ({count(len(comparison.tests), 'test')}, adjusted together); "
        "implementations of one letter were not found different",
        console=console,
    )
    if comparison.doubt:
        print_line("so few trials can show no difference beside as many tests: take more --trials", console=console)
    print_line(f"pages: {page}", console=console)
