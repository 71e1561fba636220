"""bench simulate: write a recording of the simulated joint, its parameters, or recordings of its wear over months."""

from __future__ import annotations

import re
from dataclasses import asdict
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from bench.helpers import print_line, replacing
from bench.helpers.errors import BenchError
from bench.helpers.option_groups import OptionGroup, grouped, option
from problems.backlash import TRUTH
from problems.backlash.commands import Force, about_backlash

if TYPE_CHECKING:
    from bench.contract.typing import Options
    from problems.backlash.joint import Joint

# The heavy imports wait until they are needed: no other command should wait for numba.

SAMPLE = 0.002  # s, the sampling period of a simulated recording
NEW_GAP, WORN_GAP, MONTHLY_NOISE = 0.0003, 0.0039, 0.2  # rad, rad, rps: the defaults of a wear curve


class RecordingOptions(OptionGroup, panel="Recording"):
    """What is recorded."""

    duration: float | None = option(help="Seconds to record.", show_default="12 load turns")
    sweep: float | None = option(
        help="The angle in rad by which the load turns forth and back, from rest, as a robot's wrist does.",
        show_default="it turns on in one direction",
    )
    start_angle: float | None = option(
        help="The load's angle in rad when the recording starts.", show_default="0.141; random with --wear"
    )
    encoder_bits: int | None = option(min=8, max=32, help="Read the speed through an encoder.")
    noise: float | None = option(
        help="Peak-to-peak value in rps of uniform white noise (eqs. 7.1, 7.2).", show_default="0; 0.2 with --wear"
    )
    seed: int = option(0, min=0, help="The seed of the noise.")


class Wear(OptionGroup, panel="Wear"):
    """The months of a joint that wears."""

    months: int | None = option(
        None,
        "--wear",
        metavar="MONTHS",
        help="Write a recording for each month, with a growing gap, and truth.csv into a folder. The gap given is "
        "that of the first month (0.0003 rad without one).",
    )
    worn: float | None = option(help="With --wear: the half-gap in rad of the last month; 0.0039 by default.")


@about_backlash
@grouped
def simulate(
    output: Annotated[
        Path,
        typer.Argument(
            help="The .csv file to write: time in s, motor speed in rps, position in rad, current in A. A .toml file "
            "gets the joint's parameters instead, to edit; with --wear, it is a folder."
        ),
    ],
    level: Annotated[int | None, typer.Option(min=1, max=20, help="A level 1 … 20 of the thesis's datasets.")] = None,
    half_gap: Annotated[
        float | None, typer.Option(min=0.0, help="The half-gap delta in rad, instead of a level.")
    ] = None,
    joint: Annotated[
        Path | None,
        typer.Option(help="A TOML file with parameters of the joint; 'bench simulate joint.toml' writes one."),
    ] = None,
    *,
    recording: RecordingOptions,
    wear: Wear,
    force: Force = False,
) -> None:
    """Simulate a joint with backlash at constant speed, or turning back and forth, and write its recording.

    With --wear 24, write a recording for each month instead, of a gap that grows by a three-phase wear curve.
    """
    import numpy as np

    from problems.backlash import joint as joints
    from problems.backlash.joint.parameters import joint_text
    from problems.backlash.joint.writing import check_output, write_recording

    if level is not None and half_gap is not None:
        raise BenchError("give either --level 1 … 20 or --half-gap in rad, not both")
    gap = joints.half_gap(level) if level is not None else half_gap
    if wear.worn is not None and wear.months is None:
        raise BenchError("--worn is the gap of the last month of --wear MONTHS; give that too")
    made = joints.load_joint(joint)
    sweep = recording.sweep
    at_rest = 0.0 if recording.encoder_bits is None else SAMPLE  # an encoder's first speed needs the sample before
    options: Options = {"duration": 12 * made.turn, "settle": 1.2 if sweep is None else at_rest}
    options |= {name: value for name, value in asdict(recording).items() if value is not None}
    if wear.months is not None:
        options |= {"new": NEW_GAP if gap is None else gap, "worn": WORN_GAP if wear.worn is None else wear.worn}
        _write_months(output, force, made, {"months": wear.months, "noise": MONTHLY_NOISE} | options)
    elif output.suffix.lower() == ".toml":
        if gap is not None:
            raise BenchError(
                f"{output} gets the joint's parameters, which hold no gap; leave out --level and --half-gap"
            )
        check_output(output, ".toml", force=force)
        with replacing(output) as temporary:
            temporary.write_text(joint_text(made), encoding="utf-8")
        print_line(f"{output}: the joint's parameters, for --joint")
    else:
        check_output(output, ".csv", force=force)
        if gap is None:
            raise BenchError("give either --level 1 … 20 or --half-gap in rad")
        noise, seed = options.pop("noise", 0.0), options.pop("seed")
        run = joints.simulate(made, half_gap=gap, **options)
        measured = joints.with_noise(run.speed, noise, np.random.default_rng(seed))
        write_recording(output, run.time, measured, position_rad=run.position, current_a=run.current)
        print_line(
            f"{output}: {len(run.time)} samples, half-gap {gap:.4g} rad, peak disturbance {run.peak:.4f} rps"
            + (" in less than one load turn" if sweep is None and run.fine.time[-1] < 0.999 * made.turn else "")
            + (" at full speed" if sweep is not None else "")
            + (f", noise of {noise:g} rps peak to peak" if noise else "")
            + (
                f"; friction of {made.friction:.0%} of gravity's torque never opens the gap"
                * (1 <= made.friction < inf)
            )
        )


def _write_months(folder: Path, force: bool, joint: Joint, options: Options) -> None:
    """Write the folder of a wear curve, complete or not at all."""
    from rich.console import Console
    from rich.progress import track

    from problems.backlash.joint.wear import monthly_recordings
    from problems.backlash.joint.writing import write_recording

    _check_folder(folder, force)
    stderr = Console(stderr=True)
    made = monthly_recordings(joint, **options)
    hidden = not stderr.is_terminal
    months = list(track(made, "simulating", options["months"], console=stderr, transient=True, disable=hidden))
    rows = [f"{month.name},{month.half_gap!r},{month.peak!r}" for month in months]
    with replacing(folder.resolve()) as temporary:  # "." and ".." have a name then
        temporary.mkdir()
        for month in months:
            write_recording(temporary / f"{month.name}.csv", month.time, month.speed)
        (temporary / TRUTH).write_text("\n".join(["month,half_gap_rad,amplitude_rps", *rows, ""]), encoding="utf-8")
    print_line(
        f"{folder}: {len(months)} months of {len(months[0].time)} samples, half-gap {months[0].half_gap:.4g} to "
        f"{months[-1].half_gap:.4g} rad, peak disturbance {months[0].peak:.4f} to {months[-1].peak:.4f} rps, noise of "
        f"{options['noise']:g} rps peak to peak; the truth is in {TRUTH}"
    )


def _check_folder(folder: Path, force: bool) -> None:
    """Raise BenchError for a folder that may not be replaced: one that holds other files than a wear curve's."""
    from problems.backlash.joint.writing import check_folder

    check_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise BenchError(f"{folder} is a file; --wear writes a folder")
    try:
        names = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    except OSError as error:
        raise BenchError(f"{folder} cannot be written: {error.strerror}") from error
    if foreign := [name for name in names if name != TRUTH and not re.fullmatch(r"\d{4}-\d\d\.csv", name)]:
        raise BenchError(f"{folder} holds other files, such as {foreign[0]}; choose another folder")
    if names and not force:
        raise BenchError(f"{folder} holds a wear curve already; choose another folder, or replace it with --force")
