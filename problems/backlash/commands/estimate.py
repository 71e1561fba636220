"""bench estimate: from recordings of motor speed to the backlash of joints."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from bench.helpers import print_error, print_line, replacing
from bench.helpers.errors import BenchError
from problems.backlash import EARLY_RAD
from problems.backlash.commands import about_backlash

ALARM = 3  # the exit code for a verdict that --fail-on names; 1 is for recordings that failed, 2 for bad input

# The heavy imports wait until they are needed: no other command should wait for numba.

_recording, _fit, _verdict = (partial(typer.Option, rich_help_panel=panel) for panel in ("Recording", "Fit", "Verdict"))


@about_backlash
def estimate(
    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORDING",
            help="Recordings of motor speed at constant reference speed (csv, txt, xlsx, parquet), or folders of them.",
        ),
    ],
    speed: Annotated[
        str | None, _recording(metavar="COLUMN", help="The column of motor speed, or of its position in a unit of one.")
    ] = None,
    unit: Annotated[str | None, _recording(help="rps, rpm, rad/s or deg/s; of a position rev, rad or deg.")] = None,
    joint_column: Annotated[
        str | None,
        _recording(
            metavar="COLUMN",
            help="Of files with several joints: the column that names the joint of each line, or the pattern of a "
            "column for each joint, as 'speed_*', whose asterisk stands for the joint's name.",
        ),
    ] = None,
    window: Annotated[
        str | None, _recording(metavar="BEGIN:END", help="The part to use in s, as 18.99:20.11, 2: or :10.")
    ] = None,
    gear_ratio: Annotated[
        float | None,
        _fit(
            help="Motor turns for each load turn, which with the mean speed give its time.",
            show_default="the time found in the signal",
        ),
    ] = None,
    single: Annotated[
        bool, _fit("--single", help="Fit one oscillation: less than a load turn, as of a robot's wrist.")
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
        float,
        _verdict(metavar="RAD", help="The half-gap above which backlash has progressed."),
    ] = EARLY_RAD,
    fail_on: Annotated[
        Literal["early", "progressed"] | None,
        _verdict(help="Exit with 3 where a joint's latest verdict is that bad; early includes the undecided."),
    ] = None,
    resamples: Annotated[int, _verdict(min=0, help="Bootstrap resamples; 0 for no interval.")] = 200,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE|FOLDER", help="Draw the fit, and the trend of many recordings: svg, png or pdf, or a folder."
        ),
    ] = None,
    page: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="Write a page with verdicts, trends and the fits.")
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a row for each recording, with all digits.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print a JSON list with an object for each file instead.")
    ] = False,
) -> None:
    """Estimate the backlash of a joint from a recording of its motor's speed, with a confidence interval.

    Several recordings are estimated one by one: the command reports those it cannot use, estimates the others, and
    ends with 1, or with 3 for a verdict that --fail-on names. A date (joint4_2024-01.csv) or a number in the file names
    distinguishes joints and times, else the order of the files does; a subfolder is a joint of its own. Each joint's
    trend follows, the fastest first, with the time at which it reaches the limit.
    """
    from rich.console import Console
    from rich.progress import track

    from problems.backlash.joint.writing import check_folder
    from problems.backlash.recordings import parse_window, read_joints
    from problems.backlash.sensor import formatting, recording_files, records
    from problems.backlash.sensor.batch import Estimated, Failed, estimate_files
    from problems.backlash.sensor.estimate import Settings
    from problems.backlash.sensor.trend import joints_of
    from problems.backlash.signature.calibration import load_calibration

    stderr = Console(stderr=True)
    paths = recording_files.find(recordings)
    settings = Settings(gear_ratio, single, limit_rad=limit, resamples=resamples)
    if calibration is not None:
        settings = replace(settings, calibration=None if calibration == "none" else load_calibration(calibration))
    part = parse_window(window) if window is not None else (None, None)
    if plot is not None:
        from problems.backlash.sensor import plots

        plots.check_output(plot)
    for output in filter(None, (csv, page)):
        check_folder(output)

    read = partial(read_joints, speed=speed, unit=unit, window=part, joint_column=joint_column)
    made = estimate_files(paths, read, settings, n_jobs=-1)
    bar = track(made, "estimating", len(paths), console=stderr, transient=True, disable=not stderr.is_terminal)
    outcomes = [outcome for outcomes in bar for outcome in outcomes]
    stray = [one for one in outcomes if isinstance(one, Failed) and one.stray and str(one.path) not in recordings]
    for outcome in stray:  # of a folder
        print_line(f"{outcome.error}; it was left out", console=stderr)
    outcomes = [outcome for outcome in outcomes if outcome not in stray]
    several = len(paths) > 1 or len(outcomes) > 1
    names = recording_files.display_names([one.path for one in outcomes], [one.joint for one in outcomes])
    good = [outcome for outcome in outcomes if isinstance(outcome, Estimated)]
    failed = [outcome for outcome in outcomes if isinstance(outcome, Failed)]
    if several:  # after the bar, whose line they would be glued to
        for outcome in failed:
            print_error(outcome.error)
    joints = joints_of(good, settings)
    trends = [joint.trend for joint in joints if joint.trend]
    if as_json:
        print(json.dumps(records.json_objects(outcomes, joints), indent=1, ensure_ascii=False))
    elif several:
        formatting.print_table(outcomes, names, trends, settings)
    elif good:
        width = stdout.width if (stdout := Console()).is_terminal else None
        print_line("\n".join(formatting.estimate_lines(good[0], settings, width)))
    if csv is not None:
        import pandas as pd

        with replacing(csv) as temporary:
            pd.DataFrame(records.csv_rows(outcomes, joints)).to_csv(temporary, index=False)
    if page is not None:
        from problems.backlash.sensor import page as pages

        pages.write(page, outcomes, names, joints, settings)
        print_line(f"page: {page}", console=stderr)
    if plot is not None and good:
        pictures = plots.save_figures(plot, good, trends, settings, alone=not several)
        line = str(pictures[0]) if len(pictures) == 1 else f"{len(pictures)} pictures in {plot}"
        nothing = "no joint has two recordings, so there is no trend to draw; give --plot a folder for each one's fit"
        print_line(line if pictures else nothing, console=Console(stderr=as_json))
    if not good:
        alone = failed[0].error if failed else "there is no recording in the folder"
        raise BenchError(f"none of the {len(outcomes)} recordings could be estimated" if len(failed) > 1 else alone)
    if failed:
        print_error(f"{len(failed)} of the {len(outcomes)} recordings could not be estimated")
    alarms = [joint for joint in joints if fail_on and formatting.is_alarm(joint.latest, fail_on)]
    for joint in alarms:
        print_error(f"{joint.series.name or joint.outcomes[-1].path}: the latest verdict is {joint.latest.verdict}")
    if alarms or failed:
        raise typer.Exit(ALARM if alarms else 1)
