"""bench calibrate: map the amplitude of a joint's disturbance to its half-gap, by simulation."""

import dataclasses
import shlex
from pathlib import Path
from typing import Annotated

import typer

from bench.helpers import print_line
from bench.helpers.errors import BenchError
from problems.backlash.commands import Force, about_backlash


@about_backlash
def calibrate(
    joint: Annotated[
        Path | None, typer.Option(help="A joint's TOML file, as 'bench simulate joint.toml' writes one to edit.")
    ] = None,
    gaps: Annotated[
        str | None,
        typer.Option(
            help="Half-gaps in rad, FROM:TO:COUNT, such as 0:0.004:21.", show_default="the thesis's levels 2 to 11"
        ),
    ] = None,
    fits: Annotated[
        bool,
        typer.Option(help="Compute how strong the fits to each gap are, too, which takes a second or so a gap."),
    ] = True,
    jobs: Annotated[int, typer.Option(help="Worker processes for the fits; -1 takes every core.")] = -1,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The .toml file to write the calibration to.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="A folder for the thesis's Figs. 4.5 to 4.8 of this joint, as svg.")
    ] = None,
    force: Force = False,
) -> None:
    """Calibrate a joint: simulate it with growing gaps, and map the disturbance's amplitude to the backlash.

    The default, the thesis's joint at its levels 2 to 11, reproduces eq. 4.7, whose cubic is printed. The amplitude of
    the best fit to a recording is some per cent off; a calibration contains this difference, unless --no-fits leaves it
    out.
    """
    from problems.backlash.joint import DEFAULT, half_gap, load_joint
    from problems.backlash.joint.writing import check_output
    from problems.backlash.sensor.formatting import calibration_lines
    from problems.backlash.signature import calibration

    half_gaps = [half_gap(level) for level in range(2, 12)] if gaps is None else _gaps(gaps)
    if output is not None:
        check_output(output, ".toml", force=force)
    chosen = load_joint(joint)
    made = calibration.calibrate(chosen, half_gaps)
    if fits:
        from problems.backlash.sensor.response import response

        made = dataclasses.replace(made, **response(chosen, half_gaps, n_jobs=jobs, shown=True))
    print_line("\n".join(calibration_lines(made, is_default=chosen == DEFAULT)))
    if plot is not None:
        from problems.backlash.signature.figures import save_figures

        for path in save_figures(plot, chosen, made):
            print_line(str(path))
    if output is not None:
        made.save(output, command=_command(joint, gaps, fits=fits))
        print_line(str(output))


def _command(joint: Path | None, gaps: str | None, *, fits: bool) -> str:
    """Return the command that makes the same calibration."""
    options = {"--joint": joint, "--gaps": gaps}
    words = (str(word) for pair in options.items() if pair[1] is not None for word in pair)
    return shlex.join(["bench", "calibrate", *words, *([] if fits else ["--no-fits"])])


def _gaps(text: str) -> list[float]:
    import numpy as np

    from problems.backlash.signature.calibration import MOST_GAPS

    try:
        first, last, count = text.split(":")
        low, high, number = float(first), float(last), int(count)
    except ValueError:
        raise BenchError(f"--gaps must be FROM:TO:COUNT, such as 0:0.004:21, not {text!r}") from None
    if not (0 <= low < high < 1) or not 2 <= number <= MOST_GAPS:
        raise BenchError(
            f"--gaps must rise from at least 0 to less than 1 rad in 2 to {MOST_GAPS} half-gaps, not {text!r}"
        )
    return [float(gap) for gap in np.linspace(low, high, number)]
