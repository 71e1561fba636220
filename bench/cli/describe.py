"""bench describe: print features of problems' landscapes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli import completion
from bench.cli.console import table
from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.helpers.console import pairs, print_line
from bench.numbers import require_seed
from bench.plugins import loading, selection
from bench.sandbox.messages import describe_error

BESIDE = 4  # problems of one table


def command(
    problems: Annotated[
        list[str],
        typer.Argument(
            metavar="PROBLEM…",
            help="Problems, or patterns such as 'bbob-f*-d5-i1'.",
            autocompletion=completion.problems,
        ),
    ],
    points: Annotated[
        int | None, typer.Option(help="Points of the sample; default: 250 a dimension, at most 4,000.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the sample.")] = 0,
    problem_option: Annotated[
        list[str] | None, typer.Option(help="An option of the problems, as in unit=rpm; repeatable.")
    ] = None,
    csv: Annotated[Path | None, typer.Option(help="Write all digits into this file, a row a problem.")] = None,
) -> None:
    """Print features of the problems' landscapes, estimated from a seeded sample of points.

    Distribution of the values, linear and quadratic models, dispersion of the best points, nearest-better clustering,
    information content and fitness-distance correlation, named as in flacco. No optimizer runs.
    """
    import pandas as pd

    from bench.analysis.landscape import describe

    require_seed("the seed", seed)
    console, rows = Console(), {}
    for name in dict.fromkeys(match for pattern in problems for match in selection.matching(pattern)):
        problem = loading.load_problem(name, **pairs(problem_option))
        try:
            rows[name] = {"dimension": float(problem.dimension)} | describe(problem, points, seed)
        except BenchError:
            raise
        except Exception as error:  # a plug-in may raise anything
            raise BenchError(f"{name} cannot be evaluated: {describe_error(error)}") from error
    frame = pd.DataFrame.from_dict(rows, orient="index").rename_axis("problem")
    if csv is not None:
        with replacing(csv) as temporary:
            frame.to_csv(temporary, lineterminator="\n", encoding="utf-8")
    for first in range(0, len(frame), BESIDE):
        part = frame.iloc[first : first + BESIDE]
        features = part.map(lambda value: "–" if pd.isna(value) else f"{value:.4g}").T
        console.print(table(["feature", *map(str, part.index)], features.itertuples(), right=True), "")
    if csv is not None:
        print_line(f"features: {csv}", console=console)
