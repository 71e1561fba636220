"""bench similar: show which optimizers search alike."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli import completion
from bench.cli.console import Jobs, Parameters, table
from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.helpers.console import pairs, print_line, steps
from bench.numbers import require_seed, require_whole
from bench.plugins import loading, selection
from bench.study.budget import Budget


def command(
    optimizers: Annotated[
        list[str],
        typer.Argument(
            metavar="OPTIMIZER…", help="Two or more optimizers, or patterns.", autocompletion=completion.optimizers
        ),
    ],
    problem: Annotated[
        list[str] | None,
        typer.Option(
            help="A problem, or a pattern; repeatable. Default: five classic functions in 5 dimensions.",
            autocompletion=completion.problems,
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(help="Trials on each problem; half of them are compared with the others.")
    ] = 30,
    budget: Annotated[str, typer.Option(help="Evaluations of a trial: a number, or such as '300 * d'.")] = "1500",
    option: Parameters = None,
    seed: Annotated[int, typer.Option(help="Seed of the trials.")] = 0,
    jobs: Jobs = -1,
    plot: Annotated[Path, typer.Option(help="The file of the map (svg, pdf or png).")] = Path("similar.svg"),
    csv: Annotated[Path | None, typer.Option(help="Write the pairs with all digits into this file.")] = None,
) -> None:
    """Run optimizers on common functions, and print and draw which of them search alike.

    A trial is described by the values it reaches, the spread and the movement of the points that it evaluates, in each
    eighth of its budget. These trials do not distinguish the optimizers of one cluster: permutation tests of all pairs,
    adjusted by Holm's method, at 5%. Options of --set go to all.
    """
    from bench.analysis.similarity import similarity
    from bench.check.behaviour import behaviours, recorders
    from bench.plots import style
    from bench.plots.similarity import similarity_map
    from bench.report.wording import count, p_text

    require_whole("the trials", trials, 10)
    require_seed("the seed", seed)
    if plot.suffix not in (".svg", ".pdf", ".png"):
        raise BenchError(f"the plot {plot} must end with .svg, .pdf or .png")
    names = list(dict.fromkeys(match for pattern in optimizers for match in loading.matching(pattern)))
    if len(names) < 2:
        raise BenchError("similarity needs at least two optimizers; name another one")
    loaded = {name: loading.load_optimizer(name, **pairs(option)) for name in names}
    chosen = [name for pattern in problem or () for name in selection.matching(pattern)]
    problems = recorders(chosen)
    spent = Budget.read(budget, "--budget")
    budgets = {label: spent.evaluations(make().dimension) for label, make in problems.items()}
    least = min(budgets.values())
    require_whole("the budget of evaluations", least, 50)
    for name, loaded_optimizer in loaded.items():
        loaded_optimizer.check_budget(least, name)
    console = Console()
    with steps(console, "similar") as on_progress:
        made = behaviours(names, pairs(option), chosen, trials, budgets, seed, jobs, on_progress)
    result = similarity(made, seed=seed)
    rows = []
    for name in names:
        involved = result.pairs[(result.pairs["first"] == name) | (result.pairs["second"] == name)]
        near = involved.sort_values("distance", kind="stable").to_dict("records")[0]
        neighbour = near["second"] if near["first"] == name else near["first"]
        own_distance = float(result.distances.to_numpy()[names.index(name), names.index(name)])
        p = p_text(near["p_holm"]).removeprefix("p ").removeprefix("= ")
        rows.append((name, result.clusters[name], f"{own_distance:.3f}", neighbour, f"{near['distance']:.3f}", p))
    console.print(table(("optimizer", "cluster", "against itself", "nearest other", "distance", "p (Holm)"), rows))
    groups = [list(alike.index) for _, alike in result.clusters.groupby(result.clusters) if len(alike) > 1]
    if trials < result.needed:
        few = f"{trials // 2} against {trials // 2} trials can distinguish none of {count(len(result.pairs), 'pair')}"
        print_line(
            f"{few}: p is at least {result.least:.2g} before Holm's adjustment; take --trials {result.needed} or more",
            console=console,
        )
        groups = []
    for group in groups:
        print_line(f"alike, as far as {trials // 2} trials can show: {', '.join(group)}", console=console)
    if result.clusters.is_unique:
        print_line("Every optimizer differs from every other one.", console=console)
    conditions = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}, {trials} trials, {spent.words}"
    print_line(f"{conditions}; distance: mean Kolmogorov-Smirnov distance of what trials do, 0 to 1", console=console)
    print_line(f"the map leaves out {result.stress:.0%} of the squared distances", console=console)
    with style.context(), replacing(plot) as temporary:
        similarity_map(result).savefig(temporary, metadata={"Date": None} if plot.suffix == ".svg" else None)
    if csv is not None:
        with replacing(csv) as temporary:
            result.pairs.to_csv(temporary, index=False, lineterminator="\n", encoding="utf-8")
    print_line(f"map: {plot}", console=console)
