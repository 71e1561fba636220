"""bench estimate: from recordings of motor speed to the backlash of joints."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from bench.helpers import print_error, print_line, replacing
from bench.helpers.errors import BenchError
from bench.helpers.option_groups import OptionGroup, grouped, option
from problems.backlash import EARLY_RAD
from problems.backlash.commands import about_backlash

ALARM = 3  # the exit code for a verdict that --fail-on names; 1 is for recordings that failed, 2 for bad input

# The heavy imports wait until they are needed: no other command should wait for numba.


class Reading(OptionGroup, panel="Recording"):
    """How recordings are read."""

    speed: str | None = option(metavar="COLUMN", help="The column of motor speed, or of its position in a unit of one.")
    unit: str | None = option(help="rps, rpm, rad/s or deg/s; of a position rev, rad or deg.")
    joint_column: str | None = option(
        metavar="COLUMN",
        help="Of files with several joints: the column that names the joint of each line, or the pattern of a "
        "column for each joint, as 'speed_*', whose asterisk stands for the joint's name.",
    )
    window: str | None = option(metavar="BEGIN:END", help="The part to use in s, as 18.99:20.11, 2: or :10.")


class Fitting(OptionGroup, panel="Fit"):
    """How the signature is fitted."""

    gear_ratio: float | None = option(
        help="Motor turns for each load turn, which with the mean speed give its time.",
        show_default="the time found in the signal",
    )
    single: bool = option(False, "--single", help="Fit one oscillation: less than a load turn, as of a robot's wrist.")


class Judging(OptionGroup, panel="Verdict"):
    """How an amplitude is judged."""

    calibration: str | None = option(
        metavar="FILE|none",
        help="The joint's calibration, made by 'bench calibrate'; none estimates amplitudes alone.",
        show_default="the thesis's joint",
    )
    limit: float = option(EARLY_RAD, metavar="RAD", help="The half-gap above which backlash has progressed.")
    fail_on: Literal["early", "progressed"] | None = option(
        help="Exit with 3 where a joint's latest verdict is that bad; early includes the undecided."
    )
    resamples: int = option(200, min=0, help="Bootstrap resamples; 0 for no interval.")


class Output(OptionGroup):
    """What is drawn, written and printed."""

    plot: Path | None = option(
        metavar="FILE|FOLDER", help="Draw the fit, and the trend of many recordings: svg, png or pdf, or a folder."
    )
    page: Path | None = option(metavar="FILE.html", help="Write a page with verdicts, trends and the fits.")
    csv: Path | None = option(metavar="FILE", help="Write a row for each recording, with all digits.")
    as_json: bool = option(False, "--json", help="Print a JSON list with an object for each file instead.")


@about_backlash
@grouped
def estimate(
    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="RECORDING",
            help="Recordings of motor speed at constant reference speed (csv, txt, xlsx, parquet), or folders of them.",
        ),
    ],
    *,
    reading: Reading,
    fit: Fitting,
    verdict: Judging,
    output: Output,
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
    settings = Settings(fit.gear_ratio, fit.single, limit_rad=verdict.limit, resamples=verdict.resamples)
    if (name := verdict.calibration) is not None:
        settings = replace(settings, calibration=None if name == "none" else load_calibration(name))
    part = parse_window(reading.window) if reading.window is not None else (None, None)
    if output.plot is not None:
        from problems.backlash.sensor import plots

        plots.check_output(output.plot)
    for path in filter(None, (output.csv, output.page)):
        check_folder(path)

    read = partial(read_joints, speed=reading.speed, unit=reading.unit, window=part, joint_column=reading.joint_column)
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
    if output.as_json:
        print(json.dumps(records.json_objects(outcomes, joints), indent=1, ensure_ascii=False))
    elif several:
        formatting.print_table(outcomes, names, trends, settings)
    elif good:
        width = stdout.width if (stdout := Console()).is_terminal else None
        print_line("\n".join(formatting.estimate_lines(good[0], settings, width)))
    if output.csv is not None:
        import pandas as pd

        with replacing(output.csv) as temporary:
            pd.DataFrame(records.csv_rows(outcomes, joints)).to_csv(temporary, index=False)
    if output.page is not None:
        from problems.backlash.sensor import page as pages

        pages.write(output.page, outcomes, names, joints, settings)
        print_line(f"page: {output.page}", console=stderr)
    if output.plot is not None and good:
        pictures = plots.save_figures(output.plot, good, trends, settings, alone=not several)
        line = str(pictures[0]) if len(pictures) == 1 else f"{len(pictures)} pictures in {output.plot}"
        nothing = "no joint has two recordings, so there is no trend to draw; give --plot a folder for each one's fit"
        print_line(line if pictures else nothing, console=Console(stderr=output.as_json))
    if not good:
        alone = failed[0].error if failed else "there is no recording in the folder"
        raise BenchError(f"none of the {len(outcomes)} recordings could be estimated" if len(failed) > 1 else alone)
    if failed:
        print_error(f"{len(failed)} of the {len(outcomes)} recordings could not be estimated")
    alarms = [joint for joint in joints if verdict.fail_on and formatting.is_alarm(joint.latest, verdict.fail_on)]
    for joint in alarms:
        print_error(f"{joint.series.name or joint.outcomes[-1].path}: the latest verdict is {joint.latest.verdict}")
    if alarms or failed:
        raise typer.Exit(ALARM if alarms else 1)
