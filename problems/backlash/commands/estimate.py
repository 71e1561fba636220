"""bench estimate: from recordings of motor speed to the backlash of joints."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bench.cli.console import pairs, print_error, print_line
from bench.errors import BenchError

if TYPE_CHECKING:
    from problems.backlash.recordings import Recording
    from problems.backlash.sensor.batch import Estimated, Failed
    from problems.backlash.sensor.estimate import Settings
    from problems.backlash.sensor.repeated_runs import RunSettings
    from problems.backlash.sensor.trend import Trend

# The heavy imports wait until they are needed: no other command should wait for numba.

WIDTH = 160  # of a table that is not printed on a terminal

_recording, _fit, _verdict, _runs = (
    partial(typer.Option, rich_help_panel=panel) for panel in ("Recording", "Fit", "Verdict", "Runs of an optimizer")
)


def estimate(
    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORDING...",
            help="Recordings of motor speed at constant reference speed (csv, txt, xlsx, parquet), folders of them, or "
            "patterns such as 'joint4_*.csv'.",
        ),
    ],
    time: Annotated[str | None, _recording(help="The column of time, by heading or number from 1.")] = None,
    speed: Annotated[str | None, _recording(help="The column of motor speed.")] = None,
    position: Annotated[str | None, _recording(help="The column of motor position, instead of speed.")] = None,
    unit: Annotated[str | None, _recording(help="rps, rpm, rad/s or deg/s; of a position rev, rad or deg.")] = None,
    time_unit: Annotated[str | None, _recording(help="s, ms or us.")] = None,
    rate: Annotated[
        float | None, _recording(metavar="HZ", help="The sampling rate, instead of a column of time.")
    ] = None,
    window: Annotated[
        str | None, _recording(metavar="BEGIN:END", help="The part to use in s, as 18.99:20.11, 2: or :10.")
    ] = None,
    nominal: Annotated[
        float | None, _recording(metavar="RPS", help="The motor's nominal speed; a wrong unit is reported.")
    ] = None,
    period: Annotated[
        float | None, _fit(metavar="S", help="The time of a load turn.", show_default="found in the signal")
    ] = None,
    gear_ratio: Annotated[
        float | None, _fit(help="Motor turns a load turn, which with the mean speed give its time.")
    ] = None,
    turns: Annotated[int | None, _fit(min=1, help="Load turns to fit.", show_default="all there are")] = None,
    single: Annotated[
        bool, _fit("--single", help="Fit one oscillation: less than a load turn, as of a robot's wrist.")
    ] = False,
    constrained: Annotated[
        bool, _fit("--constrained", help="Fit under the constraints of the thesis's section 7.2.2, too.")
    ] = False,
    calibration: Annotated[
        str | None,
        _verdict(
            metavar="FILE|none",
            help="The joint's calibration, made by 'bench calibrate'; none estimates amplitudes alone.",
            show_default="the thesis's joint",
        ),
    ] = None,
    limit: Annotated[
        float | None,
        _verdict(metavar="RAD", help="The half-gap above which backlash has progressed.", show_default="0.0021"),
    ] = None,
    confidence: Annotated[float, _verdict(help="The level of the intervals.")] = 0.95,
    resamples: Annotated[int, _verdict(min=0, help="Bootstrap resamples; 0 for no interval.")] = 200,
    seed: Annotated[int, _verdict(min=0, help="The seed of the bootstrap and the runs.")] = 0,
    optimizer: Annotated[
        str | None, _runs(help="Also run this optimizer on each recording, as the thesis does.")
    ] = None,
    runs: Annotated[int, _runs(min=1, help="How many runs.")] = 30,
    budget: Annotated[int, _runs(min=1, help="Evaluations a run.")] = 60_000,
    option: Annotated[list[str] | None, _runs("--set", help="A parameter of the optimizer, as agents=300.")] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|FOLDER", help="Draw the fit, and the trend of many recordings: svg, png or pdf, or a folder."
        ),
    ] = None,
    jobs: Annotated[int, typer.Option(help="Worker processes, for many recordings; -1 takes every core.")] = -1,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON list with an object a file instead.")] = False,
) -> None:
    """Estimate the backlash of a joint from a recording of its motor's speed, with a confidence interval.

    Several recordings are estimated one by one: the command reports those it cannot use, estimates the others, and
    ends with 1. A date (joint4_2024-01.csv) or a number in the file names distinguishes joints and times, else the
    order of the files does; a subfolder is a joint of its own. Each joint's trend follows, the fastest first, with the
    time at which it reaches the limit.
    """
    from rich.console import Console

    from problems.backlash.recordings import parse_window, read
    from problems.backlash.sensor import recording_files
    from problems.backlash.sensor.batch import Estimated

    paths, remarks = recording_files.find(recordings)
    settings = _settings(
        calibration, period=period, gear_ratio=gear_ratio, nominal_rps=nominal, turns=turns, single=single,
        constrained=constrained, limit_rad=limit, resamples=resamples, confidence=confidence, seed=seed,
    )  # fmt: skip
    asked = _run_settings(optimizer, option, runs, budget, seed)
    begin, end = parse_window(window) if window is not None else (None, None)
    if plot is not None:
        from problems.backlash.sensor import plots

        plots.check_output(plot)

    def recording(path: Path) -> Recording:
        found = read(path, time=time, speed=speed, position=position, unit=unit, time_unit=time_unit, rate=rate)
        return found.window(begin, end) if window is not None else found

    for remark in remarks:
        print_line(remark, console=Console(stderr=True))
    outcomes = _estimate_all(paths, recording, settings, asked, jobs)
    good = [outcome for outcome in outcomes if isinstance(outcome, Estimated)]
    trends = _trends(good, settings)
    _print(outcomes, recording_files.short_names(paths), trends, settings, as_json=as_json)
    if plot is not None and good:
        made = plots.save_figures(plot, good, trends, settings, alone=len(paths) == 1)
        nothing = "no joint has two recordings, so there is no trend to draw; give --plot a folder for each one's fit"
        line = str(made[0]) if len(made) == 1 else f"{len(made)} pictures in {plot}" if made else nothing
        print_line(line, console=Console(stderr=as_json))
    _end(outcomes, len(good))


def _settings(calibration: str | None, **options: Any) -> Settings:
    """Return the settings; an option that is None keeps its default."""
    from problems.backlash.sensor.estimate import Settings
    from problems.backlash.signature.calibration import load_calibration

    given = {name: value for name, value in options.items() if value is not None}
    if calibration is not None:
        given["calibration"] = None if calibration == "none" else load_calibration(calibration)
    return Settings(**given)


def _run_settings(
    optimizer: str | None, option: list[str] | None, runs: int, budget: int, seed: int
) -> RunSettings | None:
    """Return which optimizer is to be run, if any."""
    if optimizer is None:
        if option:
            raise BenchError("--set is for the optimizer, of which there is none; give --optimizer too")
        return None
    from problems.backlash.sensor.repeated_runs import RunSettings

    return RunSettings(optimizer, pairs(option), runs, budget, seed)


def _estimate_all(
    paths: Sequence[Path], read: Callable[[Path], Recording], settings: Settings, runs: RunSettings | None, jobs: int
) -> list[Estimated | Failed]:
    """Return the outcome of every file; show a bar on a terminal, and print each of several failures at once."""
    from problems.backlash.sensor.batch import Failed, estimate_files

    made: Iterable[Estimated | Failed] = estimate_files(paths, read, settings, runs, jobs=jobs)
    if len(paths) > 1 and sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import track

        made = track(made, "estimating", len(paths), console=Console(stderr=True), transient=True)
    outcomes = []
    for outcome in made:
        outcomes.append(outcome)
        if isinstance(outcome, Failed) and len(paths) > 1:
            print_error(outcome.error)
    return outcomes


def _trends(good: Sequence[Estimated], settings: Settings) -> list[Trend]:
    """Return the trend of every joint with two recordings or more, the fastest first."""
    if len(good) < 2:
        return []
    from problems.backlash.sensor.recording_files import series
    from problems.backlash.sensor.trend import fastest_first, trend

    return fastest_first(
        trend(
            each, [good[i].estimate for i in each.members], limit_rad=settings.limit_rad, confidence=settings.confidence
        )
        for each in series([outcome.path for outcome in good])
        if len(each.members) > 1
    )


def _print(
    outcomes: Sequence[Estimated | Failed],
    names: Sequence[str],
    trends: Sequence[Trend],
    settings: Settings,
    *,
    as_json: bool,
) -> None:
    """Print one estimate in lines, several as a table with notes and trends, or all of them as JSON."""
    from problems.backlash.sensor import formatting
    from problems.backlash.sensor.batch import Estimated

    lines: list[str] = []
    if as_json:
        print(json.dumps([formatting.json_object(each) for each in outcomes], indent=1, ensure_ascii=False))
    elif len(outcomes) > 1:
        from rich.console import Console

        console = Console()
        if not console.is_terminal:
            console = Console(width=WIDTH)
        console.print(formatting.table(outcomes, names, settings), highlight=False)
        lines = formatting.notes(outcomes, names)
        lines += [line for each in trends for line in formatting.trend_lines(each, settings)]
    elif isinstance(outcomes[0], Estimated):
        lines = formatting.estimate_lines(outcomes[0], settings)
    for line in lines:
        print_line(line)


def _end(outcomes: Sequence[Estimated | Failed], good: int) -> None:
    """Raise BenchError where no recording could be estimated, and end with 1 where not all could be."""
    from problems.backlash.sensor.batch import Failed

    if len(outcomes) == 1 and isinstance(outcomes[0], Failed):
        raise BenchError(outcomes[0].error)
    if not good:
        raise BenchError(f"none of the {len(outcomes)} recordings could be estimated")
    if good < len(outcomes):
        print_error(f"{len(outcomes) - good} of the {len(outcomes)} recordings could not be estimated")
        raise typer.Exit(1)
