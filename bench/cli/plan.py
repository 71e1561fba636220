"""bench plan: what a study's tests can find before any trial, or from its trials how many more would separate which."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from bench.errors import BenchError
from bench.helpers.console import print_line
from bench.numbers import is_finite

SHOWN = 20  # pairs that are printed; the report's table has all


def command(
    output: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER|STUDY.toml",
            help="The folder that 'bench run' wrote, or a study that has no trials yet.",
        ),
    ],
    power: Annotated[float, typer.Option(help="The chance to separate a pair, which is to be reached.")] = 0.8,
) -> None:
    """Estimate from a study's trials how many more would separate which optimizers, with a power of 80%.

    Of a study file, print what its tests can find before any trial: the smallest A12, the chance that a trial of one
    optimizer ends lower, as it is, with more trials, and with more problems.

    A pair is separated where a report calls one optimizer separably lower. The estimates are as uncertain as the
    trials; use them for a new study with another seed.
    """
    if not is_finite(power) or not 0.05 <= power <= 0.99:
        raise BenchError(f"the power is a chance from 0.05 to 0.99, such as 0.8, not {power:g}")

    if output.suffix == ".toml":
        _before(output, power)
        return
    from bench.results.results import StoredResults
    from bench.topics.findings import Findings
    from bench.topics.trials import section as trials

    findings, console = Findings(StoredResults(output)), Console()
    if len(findings.trials.optimizers) < 2:
        raise BenchError(f"{output} holds one optimizer only, so there is no pair to separate")
    if findings.trials.frame.empty or not len(findings.final.medians):
        raise BenchError(f"{output} holds no problem with trials of every optimizer yet; run the study first")
    needed = findings.final.needed_for(power)
    if len(needed):
        shown = trials.rows(needed)
        for row in shown.head(SHOWN).to_dict("records"):
            limits, about = (f" [{row[name]}]" if row["range"] else "" for name in ("interval", "range"))
            pair = f"{row['problem']}: {row['first']} and {row['second']}"
            more = f", {row['more']} more" if row["more"] else ""
            chance = f"A12 {row['A12']:.2f}{limits} of {row['trials']} trials"
            print_line(f"{pair}, {chance}: {row['needed']}{about} trials{more}", console=console)
        if len(shown) > SHOWN:
            print_line(f"… and {len(shown) - SHOWN:,} more pairs", console=console)
    for text in (*trials.extension_text(findings), *trials.summary(needed, len(findings.final.pairs), power)):
        print_line(text, console=console)


def _before(path: Path, power: float) -> None:
    from bench.study import Study
    from bench.topics.trials.design import foreseen

    study = Study.load(path)
    if len(study.optimizers) < 2:
        raise BenchError(f"{path} has one optimizer only, so there is no pair to separate")
    for line in foreseen(study, power):
        print_line(line, console=Console())
