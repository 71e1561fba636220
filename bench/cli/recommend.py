"""bench recommend: choose an optimizer for a problem by what others reached on similar problems."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.cli import completion
from bench.cli.console import ProblemParameters, table
from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.helpers.console import pairs, print_line
from bench.helpers.text import file_name


def command(
    problem: Annotated[
        str, typer.Argument(help="A problem's name, or file.py:Class.", autocompletion=completion.problems)
    ],
    folders: Annotated[
        list[Path],
        typer.Option(
            "--from", metavar="FOLDER", help="A study's folder to learn from; repeatable.",
            autocompletion=completion.folders,
        ),
    ],
    budget: Annotated[str, typer.Option(help="Evaluations to spend: a number, or such as '100 * d'.")],
    problem_option: ProblemParameters = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Write the study that tests the advice (TOML); default: print it."),
    ] = None,
) -> None:  # fmt: skip
    """Recommend an optimizer for a problem, and print the study that tests the advice.

    A sample of the problem, charged to the budget, shows the features of its landscape. The advice is the best
    optimizer on the five problems of the folders with the most similar features, where such a choice is shown to be
    better than one optimizer for all, by leaving functions out; else it is that single best.
    """
    from bench.topics.portfolio.advice import recommend

    if output is not None and output.suffix != ".toml":
        raise BenchError(f"the output {output} must end with .toml")
    name = "recommended" if output is None else file_name(output.stem)
    advice = recommend(problem, folders, budget, pairs(problem_option), name)
    console = Console()
    if len(advice.nearest):
        near = [(row["problem"], f"{row['distance']:.2f}", row["best"]) for row in advice.nearest.to_dict("records")]
        console.print(table(("most similar problem", "distance", "best there"), near), "")
    where, reached = ("these", "targets after the sample") if len(advice.nearest) else ("all", "targets")
    heads = (f"best on {where}", reached, "points above the single best, without a sample")
    best = []
    for row in advice.best.to_dict("records"):
        gain, low, high = (100 * float(row[name]) for name in ("gain", "low", "high"))
        interval = "" if isnan(low) else f" ({low:+.1f} to {high:+.1f})"
        best.append((row["optimizer"], f"{row['score']:.1%}", f"{gain:+.1f}{interval}"))
    console.print(table(heads, best), "")
    for note in advice.notes:
        print_line(note, console=console)
    if advice.study is None:
        print_line("No study can test this, as the results were imported.", console=console)
        return
    text = advice.study.to_toml()
    if output is None:
        print_line(f"\n{text}", console=console)
        return
    if output.exists() and output.read_text(encoding="utf-8") != text:
        raise BenchError(f"{output} is there already, with other content; give another --output")
    with replacing(output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    print_line(f"study: {output}; test the advice with: bench run {output}", console=console)
