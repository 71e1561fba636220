"""Simulate how strong the best fits to a joint's recordings are, where the true peak is known (section 7.3).

    >>> fits = response(Joint(), made.half_gap)    # for a Calibration "made" of the same joint
    >>> dataclasses.replace(made, **fits).expected(42.0)    # strength of a fit -> peak, rpm

The peak of a disturbance is that of an impact's first swing; a fit is a damped sine through all that follows. On the
default joint the peak is 7% above the mean |A| at the small gaps and 2% below it at 0.0037 rad, and the place of the
samples between two of the motor's moments changes |A| by 1 to 3% (standard deviation). It changes the root of the
oscillation's energy (:func:`~problems.backlash.signature.model.strength`) by 0.4 to 1% only, so a calibration uses
that. Without backlash the fit is to the load's own gravity ripple.

The recordings of a half-gap differ evenly in their start within a load turn and in the place of their samples. They are
free of noise: the noise of section 7.3, low or high, changes the mean fit of levels 2 to 20 by at most 1.3%.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import track

from bench.contract.numbers import require_jobs
from bench.contract.typing import Floats
from problems.backlash.joint import Joint, simulate
from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Settings, to_fit
from problems.backlash.signature.model import TAU, strength

RATE = 500.0  # Hz; the sampling rate of the recordings
TURNS = 12  # load turns of a recording, as the published ones have
FITS = 8  # recordings of a half-gap, each with another start in a load turn and another place of the samples


def response(joint: Joint, half_gaps: Sequence[float], *, n_jobs: int = 1, shown: bool = False) -> dict[str, Any]:
    """Return what a calibration has of the fits to each half-gap's recordings, by the names of its attributes.

    Args:
        joint: the joint and its controller.
        half_gaps: (m,) rad; each takes some seconds.
        n_jobs: worker processes; -1 takes every core.
        shown: show a progress bar on stderr.

    Raises:
        BenchError: where a half-gap cannot be simulated or fitted, and for a number of jobs that cannot be.
    """
    require_jobs("the number of jobs", n_jobs)
    fits = Parallel(n_jobs=n_jobs, return_as="generator")(delayed(_fits)(joint, gap) for gap in half_gaps)
    bar = track(fits, "fits", len(half_gaps), console=Console(stderr=True), transient=True, disable=not shown)
    found = np.array(list(bar))
    fitted, ringing, decay, ripple = found.mean(axis=1).T
    scatter = found[:, :, 0].std(axis=1)
    return {"fitted": fitted, "scatter": scatter, "shown": {"ringing": ringing, "decay": decay, "ripple": ripple}}


def _fits(joint: Joint, gap: float) -> Floats:
    """Return the fits, (FITS, 4), to a half-gap's recordings, sampled at evenly spaced places.

    Of each: the strength in rpm, the ringing in Hz, the decay in 1/s and the load's ripple in rpm.
    """
    turn = joint.turn * RATE  # in samples
    made = simulate(joint, half_gap=gap, duration=((TURNS + 1) * turn + 1) / RATE, rate=RATE)
    stride = (len(made.fine.speed) - 1) // (len(made.speed) - 1)
    count = int(TURNS * turn + 1e-6) + 1
    fits = np.full((FITS, 4), np.nan)
    for i in range(FITS):
        first = int(turn * i / FITS) * stride + stride * i // FITS
        speed = made.fine.speed[first::stride][:count]
        problem, folded, _ = to_fit(Recording(0.0, 1 / RATE, speed), Settings(calibration=None), joint.turn)
        x = problem.reference().x
        if folded:  # always, as there are several turns
            fits[i] = 60 * strength(x), folded.ringing, x[TAU], 60 * folded.ripple
    return fits
