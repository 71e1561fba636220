"""bench complexity: the complexity table of the CEC competitions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli import completion
from bench.cli.console import Parameters, table
from bench.helpers.atomic import replacing
from bench.helpers.console import pairs, print_line, steps
from bench.numbers import require_seed, require_whole
from bench.plugins import loading, selection

COLUMNS = {
    "dimension": "d",
    "optimizer": "optimizer",
    "T0": "T0 s",
    "T1": "T1 s",
    "T2": "T2 s",
    "complexity": "(T2 − T1) / T0",
}


def command(
    optimizers: Annotated[
        list[str],
        typer.Argument(metavar="OPTIMIZER…", help="Optimizers, or patterns.", autocompletion=completion.optimizers),
    ],
    problem: Annotated[
        list[str] | None,
        typer.Option(
            help="A problem, or a pattern; repeatable. Default: cec2017-f18 in 10, 30 and 50 dimensions.",
            autocompletion=completion.problems,
        ),
    ] = None,
    evaluations: Annotated[int, typer.Option(help="Evaluations of a run.")] = 200_000,
    runs: Annotated[int, typer.Option(help="Runs, of which T2 is the mean time.")] = 5,
    option: Parameters = None,
    seed: Annotated[int, typer.Option(help="Seed of the runs.")] = 0,
    csv: Annotated[Path | None, typer.Option(help="Write the table with all digits into this file.")] = None,
    tex: Annotated[Path | None, typer.Option(help="Write the table as LaTeX into this file.")] = None,
) -> None:
    """Measure what an optimizer computes beside its evaluations, as the CEC competitions do: T0, T1, T2.

    T0 is the time of a million rounds of arithmetic, T1 that of the evaluations alone, T2 that of the whole run, all in
    processor seconds of this machine. Run it on an idle one, and on the same one for all optimizers of a table.
    Options of --set go to all.
    """
    from bench.check.complexity import complexities
    from bench.report.latex import to_latex
    from bench.report.parts import Table
    from bench.storage.provenance import machine

    require_whole("the evaluations", evaluations, 1)
    require_whole("the runs", runs, 1)
    require_seed("the seed", seed)
    names = list(dict.fromkeys(match for pattern in optimizers for match in loading.matching(pattern)))
    loaded = {name: loading.load_optimizer(name, **pairs(option)) for name in names}
    asked = problem or [f"cec2017-f18-d{dimension}" for dimension in (10, 30, 50)]
    problems = {name: loading.load_problem(name) for pattern in asked for name in selection.matching(pattern)}
    for name, optimizer in loaded.items():
        optimizer.check_budget(evaluations, name)
    console = Console()
    with steps(console, "complexity") as on_progress:
        found = complexities(loaded, problems, evaluations, runs, seed, on_progress)
    about = f"{machine()['processor']}, Python; {evaluations:,} evaluations, T2 the mean of {runs} runs"
    shown = found[["problem", *COLUMNS]].rename(columns=COLUMNS)
    for name in [*COLUMNS.values()][2:]:
        shown[name] = [f"{value:.3g}" for value in shown[name]]
    console.print(table([*map(str, shown)], shown.itertuples(index=False)))
    print_line(about, console=console)
    for row in found[found["evaluations"] < evaluations].to_dict("records"):
        print_line(
            f"{row['optimizer']} ended after {row['evaluations']:,} evaluations of {row['problem']}; T1 has as many",
            console=console,
        )
    if csv is not None:
        with replacing(csv) as temporary:
            found.to_csv(temporary, index=False, lineterminator="\n", encoding="utf-8")
    if tex is not None:
        caption = f"Complexity as the CEC competitions define it, in processor seconds ({about})."
        with replacing(tex) as temporary:
            latex = to_latex(Table("complexity", caption, shown.set_index("problem")), "complexity")
            temporary.write_text(latex, encoding="utf-8", newline="\n")
