"""The command line. Bad input is one sentence and exit code 2; failed trials end a run with 1, Ctrl-C with 130."""

from __future__ import annotations

import json
import signal
import sys
import tomllib
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from bench import listing, plugins
from bench.errors import BenchError
from bench.progress import Display, steps

app = typer.Typer(
    help="Compare metaheuristics: run studies, and report what may be claimed from them.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)

Output = Annotated[Path, typer.Argument(help="The folder that 'bench run' wrote.")]


def main() -> None:
    """Run the command line and turn bad input into a sentence on standard error."""
    try:
        for name in plugins.entries("commands"):  # refuses foreign modules of the distribution's generic names
            _add_command(name)
        sys.exit(app(standalone_mode=False))
    except BenchError as error:
        _say(str(error))
        sys.exit(2)
    except (KeyboardInterrupt, typer.Abort):
        _say("interrupted")
        sys.exit(130)
    except Exception as error:
        if not hasattr(error, "format_message"):  # a usage error of click, or of typer's own copy of it
            raise
        _say(error.format_message().rstrip())
        sys.exit(2)


def _say(message: str) -> None:
    """Print one red line on standard error."""
    Console(stderr=True).print(f"bench: {message}", style="red", markup=False, highlight=False, soft_wrap=True)


def _add_command(name: str) -> None:
    """Add a plug-in's sub-command; one that fails to load says so when it is called, and breaks nothing else."""
    try:
        command = plugins.load("commands", name)
    except BenchError as error:
        message = str(error)

        def command() -> None:
            raise BenchError(message)

        command.__doc__ = "(failed to load)"
    if isinstance(command, typer.Typer):
        app.add_typer(command, name=name)
    else:
        app.command(name)(command)


@app.command("list")
def list_plugins(
    kind: Annotated[
        str, typer.Argument(help="optimizers, problems, studies, commands, all, or a family such as mealpy.")
    ] = "all",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print every optimizer, those of families too, as a JSON list.")
    ] = False,
) -> None:
    """List what is installed: optimizers with lineage and parameters, problems, studies, commands."""
    if as_json:
        print(json.dumps(listing.records(kind), indent=1, default=str))
    else:
        listing.show(kind, Console())


@app.command()
def run(
    study: Annotated[str, typer.Argument(help="An installed study's name (see 'bench list studies') or a TOML file.")],
    output: Annotated[Path | None, typer.Option(help="Folder to write; default: results/runs/STUDY.")] = None,
    jobs: Annotated[int, typer.Option(help="Worker processes; -1 takes every core.")] = -1,
    backend: Annotated[str, typer.Option(help="joblib backend.")] = "loky",
    trials: Annotated[
        int | None, typer.Option(help="Trials of each optimizer on each problem, instead of the study's.")
    ] = None,
    budget: Annotated[int | None, typer.Option(help="Evaluations a trial, instead of the study's.")] = None,
    seed: Annotated[int | None, typer.Option(help="The root of all seeds, instead of the study's.")] = None,
    optimizer: Annotated[
        list[str] | None,
        typer.Option(help="Another optimizer beside the study's: a name, or path/to/file.py:ClassName; repeatable."),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Also check the optimizers (see 'bench check') before the report.")
    ] = False,
    report: Annotated[bool, typer.Option(help="Write the report when the run ends.")] = True,
) -> None:
    """Run a study, continue one that was interrupted, or extend one; then write its report.

    The same command continues where the last one ended: every finished trial is kept.
    """
    from bench.runner import WorkerDiedError
    from bench.runner import run as run_study
    from bench.study import Study

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # a polite kill ends like Ctrl-C, and stops the workers

    console = Console()
    chosen = Study.load(study).override(trials=trials, budget=budget, seed=seed).beside(optimizer or [])
    try:
        with Display(console) as display:
            outcome = run_study(
                chosen, output, n_jobs=jobs, backend=backend, on_plan=display.plan, on_trial=display.trial
            )
    except KeyboardInterrupt:
        _say("interrupted; every finished trial is kept: run the same command again to continue")
        sys.exit(130)
    except WorkerDiedError as error:
        _say(str(error))
        sys.exit(1)
    unchecked = check and not _check_folder(outcome.folder, console, jobs)
    if report:
        _report([outcome.folder], console)
    else:
        console.print(f"results in {outcome.folder}", markup=False, highlight=False, soft_wrap=True)
    if outcome.failed:
        _say(f"{outcome.failed} trials failed; see the report or 'bench status {outcome.folder}'")
    if outcome.failed or unchecked:
        sys.exit(1)


@app.command()
def check(
    name: Annotated[
        str,
        typer.Argument(
            help="An optimizer (gwo, mealpy:OriginalGWO, path/to/file.py:Class), or a folder that 'bench run' wrote."
        ),
    ],
    option: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter of the optimizer, as agents=300.")
    ] = None,
    bias: Annotated[bool, typer.Option(help="Also look for biases, which takes longer.")] = True,
    jobs: Annotated[int, typer.Option(help="Worker processes; -1 takes every core.")] = -1,
) -> None:
    """Check that an optimizer keeps the contract, and whether it favours places of the box by itself.

    Every check says what it saw and, where it failed, how to mend it. A breach of the contract ends the command with 1;
    a bias is a trait of the method, and is told. Given a study's folder, all its optimizers are checked for biases with
    their own options; what is found is noted there for the study's report.
    """
    from bench.check import check_optimizer

    console = Console()
    if name not in plugins.entries("optimizers") and (Path(name) / "study.toml").exists():
        if option:
            raise BenchError("--set is for an optimizer given by name; a study's optimizers have their own options")
        sys.exit(0 if _check_folder(Path(name), console, jobs) else 1)
    checkup = check_optimizer(
        name, bias=bias, n_jobs=jobs, on_check=lambda each: listing.show_verdict(name, each, console), **_pairs(option)
    )
    console.print(checkup.summary, markup=False, highlight=False, soft_wrap=True)
    if not checkup.conforms:
        sys.exit(1)


def _check_folder(path: Path, console: Console, jobs: int) -> bool:
    """Check the optimizers of a study's folder; return whether all could be checked, biased or not."""
    from bench.check.folder import diagnose_folder
    from bench.folder import Folder

    found, failed = diagnose_folder(Folder(path), jobs)
    for label, verdicts in found.items():
        for each in verdicts:
            listing.show_verdict(label, each, console, mend=False)  # said once by 'bench check NAME'
    for label, reason in failed.items():
        _say(f"{label} could not be checked: {reason}")
    return not failed


@app.command()
def status(output: Output) -> None:
    """Show how far a study's folder is, what failed, and where it ran."""
    from bench.results import Results

    listing.show_status(Results(output), Console())


@app.command()
def report(
    folders: Annotated[
        list[Path], typer.Argument(metavar="OUTPUT…", help="A folder that 'bench run' wrote, or several to compare.")
    ],
    output: Annotated[
        Path | None,
        typer.Option(help="Folder to write; default: OUTPUT itself, and results/comparisons/NAMES for several."),
    ] = None,
) -> None:
    """Write the report of a study's folder: a page, tables (CSV, LaTeX), figures (SVG, PDF) and a methods paragraph.

    Several folders, such as those of two versions of an optimizer, are compared as one study.
    """
    _report(folders, Console(), output)


def _report(folders: list[Path], console: Console, output: Path | None = None) -> None:
    from bench.report import write_report

    with steps(console, "report") as on_progress:
        page = write_report(*folders, output=output, on_progress=on_progress)
    console.print(f"report: {page}", markup=False, highlight=False, soft_wrap=True)


@app.command()
def export(
    output: Output,
    kind: Annotated[str, typer.Option("--format", help="ioh, coco, csv or parquet (which needs the extra parquet).")],
    folder: Annotated[
        Path | None, typer.Option("--output", help="Folder to write; default: OUTPUT/export/FORMAT.")
    ] = None,
) -> None:
    """Write a study's results for other tools: IOHanalyzer, COCO's cocopp, or as plain tables."""
    from bench.export import export as export_results
    from bench.results import Results

    made = export_results(Results(output), kind, folder or output / "export" / kind)
    console = Console()
    for note in made.notes:
        console.print(f"note: {note}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    console.print(f"export: {made.folder}", markup=False, highlight=False, soft_wrap=True)


@app.command()
def solve(
    problem: Annotated[str, typer.Argument(help="A problem's name, such as signature-12 or recording:joint2.csv.")],
    optimizer: Annotated[str, typer.Argument(help="An optimizer's name, such as gwo.")],
    budget: Annotated[int, typer.Option(help="Evaluations to spend.")] = 60_000,
    seed: Annotated[int, typer.Option(help="Repeats the run; the seed of a study's row repeats that trial.")] = 0,
    option: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter of the optimizer, as agents=300.")
    ] = None,
    problem_option: Annotated[list[str] | None, typer.Option(help="An option of the problem, as unit=rpm.")] = None,
) -> None:
    """Run one optimizer once on one problem and print what it found."""
    from bench.trial import solve as solve_once

    loaded = plugins.load_problem(problem, **_pairs(problem_option))
    chosen = plugins.load_optimizer(optimizer, **_pairs(option))
    chosen.check_budget(budget, optimizer)
    try:
        result = solve_once(loaded, chosen, budget=budget, seed=seed)
    except BenchError:
        raise
    except Exception as error:  # a plug-in may raise anything
        _say(f"{optimizer} failed on {problem}: {type(error).__name__}: {error}")
        sys.exit(1)
    listing.show_result(result, loaded, Console())


def _pairs(items: list[str] | None) -> dict[str, Any]:
    """Return KEY=VALUE texts as options; a value that is no TOML value is taken as a text."""
    options: dict[str, Any] = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key.strip():
            raise BenchError(f"{item!r} is no KEY=VALUE, as in agents=300")
        try:
            options[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            options[key.strip()] = value
    return options
