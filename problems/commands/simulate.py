"""bench simulate: write a recording of the simulated joint."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.errors import BenchError


def simulate(
    output: Annotated[Path, typer.Argument(help="The csv file to write: time in s, motor speed in rps.")],
    level: Annotated[int | None, typer.Option(min=1, max=20, help="A level 1 … 20 of the thesis's datasets.")] = None,
    half_gap: Annotated[
        float | None, typer.Option(min=0.0, help="The half-gap delta in rad, instead of a level.")
    ] = None,
    encoder_bits: Annotated[int | None, typer.Option(min=8, max=32, help="Read the speed through an encoder.")] = None,
) -> None:
    """Simulate a joint with backlash turning at constant speed, and write its recording."""
    from problems.joint import half_gap as half_gap_of  # imports numba, for which no other command should wait
    from problems.joint import simulate as run

    if output.suffix.lower() != ".csv":
        raise BenchError(f"{output} must end in .csv, as that is what is written")
    if (level is None) == (half_gap is None):
        raise BenchError("give either --level 1 … 20 or --half-gap in rad")
    gap = half_gap if half_gap is not None else half_gap_of(int(level or 0))
    made = run(half_gap=gap, encoder_bits=encoder_bits)
    table = np.column_stack([made.time, made.speed])
    try:
        np.savetxt(output, table, delimiter=",", header="time_s,speed_rps", comments="", fmt=["%.6f", "%.10g"])
    except OSError as error:
        raise BenchError(f"the recording {output} cannot be written: {error.strerror}") from error
    typer.echo(f"{output}: {len(table)} samples, half-gap {gap:.4g} rad, peak disturbance {made.peak:.4f} rps")
