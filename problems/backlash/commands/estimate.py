"""bench estimate: from recordings of motor speed to the backlash of joints."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli.console import pairs, print_error
from bench.errors import BenchError

if TYPE_CHECKING:
    from problems.backlash.recordings import Recording
    from problems.backlash.sensor.batch import Estimated, Failed
    from problems.backlash.sensor.estimate import Settings
    from problems.backlash.sensor.repeated import Plan
    from problems.backlash.sensor.trend import Trend

# The heavy imports wait until they are needed: no other command should wait for numba.

WIDTH = 160  # of a table that is read by no terminal

READING, FITTING, TELLING, RUNS = "Recording", "Fit", "Verdict", "Runs of an optimizer"


def estimate(
    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORDING...",
            help="Recordings of motor speed at constant reference speed (csv, txt, xlsx, parquet), folders of them, or "
            "patterns such as 'joint4_*.csv'.",
        ),
    ],
    time: Annotated[
        str | None,
        typer.Option(help="The column of time, by heading or number from 1.", rich_help_panel=READING),
    ] = None,
    speed: Annotated[str | None, typer.Option(help="The column of motor speed.", rich_help_panel=READING)] = None,
    position: Annotated[
        str | None, typer.Option(help="The column of motor position, instead of speed.", rich_help_panel=READING)
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(help="rps, rpm, rad/s or deg/s; of a position rev, rad or deg.", rich_help_panel=READING),
    ] = None,
    time_unit: Annotated[str | None, typer.Option(help="s, ms or us.", rich_help_panel=READING)] = None,
    rate: Annotated[
        float | None,
        typer.Option(metavar="HZ", help="The sampling rate, instead of a column of time.", rich_help_panel=READING),
    ] = None,
    window: Annotated[
        str | None,
        typer.Option(
            metavar="BEGIN:END", help="The part to use in s, as 18.99:20.11, 2: or :10.", rich_help_panel=READING
        ),
    ] = None,
    nominal: Annotated[
        float | None,
        typer.Option(
            metavar="RPS", help="The motor's nominal speed; a wrong unit is then told.", rich_help_panel=READING
        ),
    ] = None,
    period: Annotated[
        float | None,
        typer.Option(
            metavar="S", help="The time of a load turn.", show_default="found in the signal", rich_help_panel=FITTING
        ),
    ] = None,
    gear_ratio: Annotated[
        float | None,
        typer.Option(help="Motor turns a load turn, which with the mean speed give its time.", rich_help_panel=FITTING),
    ] = None,
    turns: Annotated[
        int | None,
        typer.Option(min=1, help="Load turns to fit.", show_default="all there are", rich_help_panel=FITTING),
    ] = None,
    single: Annotated[
        bool,
        typer.Option(
            "--single",
            help="Fit one oscillation: less than a load turn, as of a robot's wrist.",
            rich_help_panel=FITTING,
        ),
    ] = False,
    constrained: Annotated[
        bool,
        typer.Option(
            "--constrained",
            help="Fit under the constraints of the thesis's section 7.2.2, too.",
            rich_help_panel=FITTING,
        ),
    ] = False,
    calibration: Annotated[
        str | None,
        typer.Option(
            metavar="FILE|none",
            help="The joint's, made by 'bench calibrate'; none tells amplitudes alone.",
            show_default="the thesis's joint",
            rich_help_panel=TELLING,
        ),
    ] = None,
    limit: Annotated[
        float | None,
        typer.Option(
            metavar="RAD",
            help="The half-gap above which backlash has progressed.",
            show_default="0.0021",
            rich_help_panel=TELLING,
        ),
    ] = None,
    confidence: Annotated[float, typer.Option(help="Of the intervals.", rich_help_panel=TELLING)] = 0.95,
    resamples: Annotated[
        int, typer.Option(min=0, help="Of the bootstrap; 0 for no interval.", rich_help_panel=TELLING)
    ] = 200,
    seed: Annotated[int, typer.Option(min=0, help="Of the bootstrap and the runs.", rich_help_panel=TELLING)] = 0,
    optimizer: Annotated[
        str | None,
        typer.Option(help="Run this optimizer on each recording besides, as the thesis does.", rich_help_panel=RUNS),
    ] = None,
    runs: Annotated[int, typer.Option(min=1, help="How many runs.", rich_help_panel=RUNS)] = 30,
    budget: Annotated[int, typer.Option(min=1, help="Evaluations a run.", rich_help_panel=RUNS)] = 60_000,
    option: Annotated[
        list[str] | None,
        typer.Option("--set", help="A parameter of the optimizer, as agents=300.", rich_help_panel=RUNS),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|FOLDER", help="Draw the fit, and of many recordings the trend: svg, png or pdf, or a folder."
        ),
    ] = None,
    jobs: Annotated[int, typer.Option(help="Worker processes, for many recordings; -1 takes every core.")] = -1,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list with an object a file instead.")] = False,
) -> None:
    """Estimate the backlash of a joint from a recording of its motor's speed, with a confidence interval.

    Of several recordings each is estimated by itself: one that cannot be used costs no other its estimate, and the
    command ends with 1. Names with a date (joint4_2024-01.csv) or a number tell joints and times apart, else the order
    of the files does; a subfolder is a joint of its own. Each joint's trend is told, the fastest first, and when it
    reaches the limit.
    """  # fmt: skip
    from problems.backlash.recordings import parse_window, read
    from problems.backlash.sensor import calibration_files as files
    from problems.backlash.sensor import output
    from problems.backlash.sensor.batch import Estimated, Failed

    paths, remarks = files.find(recordings)
    settings = _settings(
        calibration, period=period, gear_ratio=gear_ratio, nominal_rps=nominal, turns=turns, single=single,
        constrained=constrained, limit_rad=limit, resamples=resamples, confidence=confidence, seed=seed,
    )  # fmt: skip
    plan = _plan(optimizer, option, runs, budget, seed)
    begin, end = parse_window(window) if window is not None else (None, None)
    if plot is not None:
        from problems.backlash.sensor import figures as drawing

        drawing.check_output(plot)

    def recording(path: Path) -> Recording:
        found = read(path, time=time, speed=speed, position=position, unit=unit, time_unit=time_unit, rate=rate)
        return found.window(begin, end) if window is not None else found

    for remark in remarks:
        typer.echo(remark, err=True)
    outcomes = _estimate_all(paths, recording, settings, plan, jobs)
    good = [outcome for outcome in outcomes if isinstance(outcome, Estimated)]
    trends = _trends(good, settings)
    if as_json:
        typer.echo(json.dumps([output.record(outcome) for outcome in outcomes], indent=1, ensure_ascii=False))
    elif len(paths) > 1:
        _print_batch(outcomes, files.short_names(paths), trends, settings)
    elif good:
        typer.echo("\n".join(output.words(good[0], settings)))
    if plot is not None and good:
        made = drawing.save_figures(plot, good, trends, settings, alone=len(paths) == 1)
        nothing = "no joint has two recordings, so there is no trend to draw; give --plot a folder for each one's fit"
        typer.echo(made[0] if len(made) == 1 else f"{len(made)} pictures in {plot}" if made else nothing, err=as_json)
    if len(outcomes) == 1 and isinstance(outcomes[0], Failed):
        raise BenchError(outcomes[0].error)
    if not good:
        raise BenchError(f"none of the {len(paths)} recordings could be estimated")
    if len(good) < len(paths):
        print_error(f"{len(paths) - len(good)} of the {len(paths)} recordings could not be estimated")
        raise typer.Exit(1)


def _settings(calibration: str | None, **options: Any) -> Settings:
    """Return the settings; an option that is None keeps its default."""
    from problems.backlash.sensor.estimate import Settings
    from problems.backlash.signature.calibration import load_calibration

    given = {name: value for name, value in options.items() if value is not None}
    if calibration is not None:
        given["calibration"] = None if calibration == "none" else load_calibration(calibration)
    return Settings(**given)


def _plan(optimizer: str | None, option: list[str] | None, runs: int, budget: int, seed: int) -> Plan | None:
    """Return which optimizer is to be run, if any."""
    from problems.backlash.sensor.repeated import Plan

    if optimizer is None:
        if option:
            raise BenchError("--set is for the optimizer, of which there is none; give --optimizer too")
        return None
    return Plan(optimizer, pairs(option), runs, budget, seed)


def _estimate_all(
    paths: Sequence[Path], read: Callable[[Path], Recording], settings: Settings, plan: Plan | None, jobs: int
) -> list[Estimated | Failed]:
    """Return what became of every file; a bar on a terminal shows how far it is, and failures are said at once."""
    from rich.console import Console
    from rich.progress import track

    from problems.backlash.sensor.batch import Failed, estimate_files

    console = Console(stderr=True)
    outcomes = []
    made = estimate_files(paths, read, settings, plan, jobs=jobs)
    for outcome in track(
        made, "estimating", len(paths), console=console, transient=True, disable=not console.is_terminal
    ):
        outcomes.append(outcome)
        if isinstance(outcome, Failed) and len(paths) > 1:
            print_error(outcome.error)
    return outcomes


def _trends(good: Sequence[Estimated], settings: Settings) -> list[Trend]:
    """Return the trend of every joint with two recordings or more, the fastest first."""
    from problems.backlash.sensor.calibration_files import series
    from problems.backlash.sensor.trend import fastest_first, trend

    return fastest_first(
        trend(
            each, [good[i].estimate for i in each.members], limit_rad=settings.limit_rad, confidence=settings.confidence
        )
        for each in series([outcome.path for outcome in good])
        if len(each.members) > 1
    )


def _print_batch(
    outcomes: Sequence[Estimated | Failed], names: Sequence[str], trends: Sequence[Trend], settings: Settings
) -> None:
    from rich.console import Console

    from problems.backlash.sensor import output

    console = Console()
    if not console.is_terminal:
        console = Console(width=WIDTH)
    console.print(output.table(outcomes, names, settings), highlight=False)
    lines = [*output.notes(outcomes, names), *(line for each in trends for line in output.trend_words(each, settings))]
    for line in lines:
        typer.echo(line)
