"""bench reproduce: read a published table critically, run its protocol again, and judge every cell."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from bench.cli.console import Jobs, Untrusted, run_shown
from bench.cli.console import table as rich_table
from bench.contract.numbers import require_seed, require_whole
from bench.helpers.atomic import replacing
from bench.helpers.console import print_line
from bench.helpers.errors import BenchError
from bench.helpers.text import count

if TYPE_CHECKING:
    from bench.reproduce.table import PaperTable
    from bench.reproduce.verdict import Judgement


def command(
    table: Annotated[
        Path,
        typer.Argument(
            help="A table as papers print it (CSV), with the columns suite, function, dimension, budget, runs, "
            "optimizer, mean and sd, or a column for each optimizer."
        ),
    ],
    read_only: Annotated[
        bool, typer.Option("--read-only", help="Only read the table critically; nothing is run.")
    ] = False,
    optimizer: Annotated[
        list[str] | None,
        typer.Option(metavar="PRINTED=NAME", help="Which optimizer here a printed name means; repeatable."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of the runs; default: results/runs/TABLE.")
    ] = None,
    beside: Annotated[
        Path | None,
        typer.Option("--beside", metavar="FOLDER", help="Judge by the trials of this folder; none is made."),
    ] = None,
    trials: Annotated[int | None, typer.Option(help="Runs of each cell, instead of the table's number.")] = None,
    seed: Annotated[int, typer.Option(help="Seed that all trials' seeds derive from.")] = 0,
    jobs: Jobs = -1,
    timeout: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Wall-clock limit of a run; one that exceeds it failed.")
    ] = None,
    untrusted: Untrusted = False,
) -> None:
    """Read a published table critically, run its protocol again, and judge every cell.

    Reading finds what no runs can have given: values below the optimum, a best above the mean, an SD that the mean and
    the best exclude, ranks and averages that do not recompute, digits that a mean of n counts cannot have. Then the
    same command runs, continues or extends the study of the table's protocol, and compares each cell by its mean, SD
    and number of runs. At most 5% of tables that are right get a false "differs". The exit code is 1 where a cell
    differs, or with --read-only contradicts itself.
    """
    from bench.reproduce.protocol import protocol_of, samples
    from bench.reproduce.section import attach
    from bench.reproduce.table import read
    from bench.reproduce.verdict import frame, judge
    from bench.results.results import StoredResults

    require_seed("--seed", seed)
    if trials is not None:
        require_whole("--trials", trials, 2)
    console = Console()
    paper = _renamed(read(table), optimizer or [])
    contradicted = _criticised(paper, console)
    if read_only and contradicted:
        sys.exit(1)
    if read_only:
        return
    made = protocol_of(paper, trials, seed, beside=None if beside is None else StoredResults(beside))
    if made.study is None:
        reasons = "; ".join(dict.fromkeys(made.reasons.values()))
        raise BenchError(f"no cell of {table} can be {'judged' if beside else 'run'}: {reasons}")
    folder = beside
    if folder is None:
        folder = run_shown(made.study, output, console, n_jobs=jobs, timeout=timeout, untrusted=untrusted).folder
    attach(table, folder)  # so that its report has the table
    judgements = judge(paper, samples(paper, made, StoredResults(folder)), made.reasons)
    _show(judgements, console)
    numbers = folder / "reproduction.csv"
    with replacing(numbers) as temporary:
        frame(judgements).to_csv(temporary, index=False)
    print_line(f"every number: {numbers}", console=console)
    if any(each.verdict == "differs" for each in judgements):
        sys.exit(1)


def _renamed(paper: PaperTable, chosen: list[str]) -> PaperTable:
    """Return the table with the optimizers that its printed names mean; raises BenchError for another form."""
    named = dict(paper.settings.get("optimizers", {}))
    known = {cell.optimizer for cell in paper.cells}
    for text in chosen:
        printed, equals, name = text.partition("=")
        if not equals or printed not in known:
            raise BenchError(f"--optimizer {text!r} must be PRINTED=NAME; the table prints {', '.join(sorted(known))}")
        named[printed] = name
    return dataclasses.replace(paper, settings={**paper.settings, "optimizers": named})


def _criticised(paper: PaperTable, console: Console) -> bool:
    """Print the contradictions of a table, and return whether there are some."""
    from bench.reproduce.criticism import criticise

    remarks, notes = criticise(paper)
    for note in (*paper.notes, *notes):
        print_line(f"note: {note}", "yellow", console)
    for remark in remarks:
        print_line(f"{remark.where}: {remark.sentence}", console=console)
    wrong, cells = len({remark.where for remark in remarks}), count(len(paper.cells), "cell")
    said = f"{wrong} of {cells} contradict themselves, each other or the problem"
    print_line(said if wrong else f"no contradiction in {cells}", console=console)
    return bool(wrong)


def _show(judgements: list[Judgement], console: Console) -> None:
    """Print a row for each cell, a sentence on each reason, and those on the table."""
    from bench.reproduce.verdict import HEADS, NOTE, sentences, shown, unjudged

    if rows := shown(judgements):
        console.print(rich_table(HEADS, rows))
        print_line(NOTE, "dim", console)
    for line in unjudged(judgements):
        print_line(line, "yellow", console)
    for line in sentences(judgements):
        print_line(line, console=console)
