"""Simulate recordings, such as the twenty of section 7.2.1 and, with noise, those of section 7.3.

A signal is simulated on first use and kept in ``$BENCH_CACHE`` or the user's cache folder. A file's name is a hash of
everything that determines its content, the simulator's source included, so a changed simulator never reads old signals.
A damaged file is detected by the checksums of its zip format and replaced.
"""

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

import numpy as np
from platformdirs import user_cache_dir

from bench.errors import BenchError
from bench.helpers import replacing
from bench.numbers import require_whole
from problems.backlash import LEVELS
from problems.backlash.joint import Joint, half_gap, parameters, simulate, simulator, with_noise
from problems.backlash.recordings import Recording

DEFAULT = Joint()

RATE = 500.0  # Hz
NOISES = ("low", "high")  # the levels of noise of section 7.3
FIRST_SAMPLES = 100  # the number of first samples at which a noisy recording may start (section 7.3)


@cache
def dataset(level: int) -> Recording:
    """Return the recording of a level 1 … 20; raises BenchError outside."""
    return simulated(half_gap(level))


def peak_to_peak(level: int, noise: str = "low") -> float:
    """Return the peak-to-peak value in rps of the noise on a dataset 1 … 20; 0 has the noise of dataset 1.

    Eq. 7.2 with the range of the authors' published recordings: 0.2 to 0.5 rps, and 1.5 times that at the high level.
    Table 7.3 lists half of the peak-to-peak value.
    """
    return (0.2 + 0.3 * (max(level, 1) - 1) / 19) * (1.5 if noise == "high" else 1.0)


def noisy(level: int, noise: str = "low", draw: int = 0) -> Recording:
    """Return a dataset with uniform white noise (eqs. 7.1 and 7.2), cut at a random one of its first 100 samples.

    It begins at 0 s. Without backlash its peak is 0 and its half-gap None.

    Args:
        level: the dataset, 1 … 20; 0 is the reference speed and noise alone, without backlash or gravity.
        noise: "low" or "high".
        draw: the number of the realisation; with the other two arguments it determines the noise and the start.

    Raises:
        BenchError: for an unknown level or noise, and a draw that is not a whole number of at least 0.
    """
    if level not in (0, *LEVELS):
        raise BenchError(f"a noisy dataset has a level from 0 (no backlash) to {LEVELS[-1]}, not {level!r}")
    if noise not in NOISES:
        raise BenchError(f"noise must be one of {', '.join(map(repr, NOISES))}, not {noise!r}")
    require_whole("draw", draw, 0)
    rng = np.random.default_rng([level, NOISES.index(noise), draw])
    clean = dataset(level or LEVELS[0])
    if not level:  # of this dataset only the length is used
        clean = Recording(0.0, clean.dt, np.full_like(clean.speed, DEFAULT.nominal_speed), peak=0.0)
    cut = int(rng.integers(FIRST_SAMPLES))
    return replace(clean, speed=with_noise(clean.speed, peak_to_peak(level, noise), rng)[cut:])


def simulated(gap: float, joint: Joint = DEFAULT) -> Recording:
    """Return a joint's recording at a half-gap in rad, from the cache if it is there and undamaged.

    It has 2401 samples at 500 Hz, or two load turns if these take longer.

    Raises:
        BenchError: as :func:`problems.backlash.joint.simulate`.
    """
    folder = Path(os.environ.get("BENCH_CACHE") or user_cache_dir("backlash-bench"))
    path = folder / f"joint-{_address(gap, joint)}.npz"
    with suppress(Exception), np.load(path, allow_pickle=False) as stored:  # a damaged file may raise nearly anything
        if stored.zip.testzip() is None:
            return Recording(0.0, 1 / RATE, stored["speed"], peak=float(stored["peak"]), half_gap=gap)
    made = simulate(joint, half_gap=gap, duration=max(4.8, 2 * joint.turn), rate=RATE)
    with suppress(OSError, BenchError):  # a read-only cache is not an error
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:  # no worker reads half a file
            np.savez(temporary, speed=made.speed, peak=made.peak)
    return Recording(0.0, 1 / RATE, made.speed, peak=made.peak, half_gap=gap)


@cache
def _sources() -> str:
    """Return a hash of the modules that determine a signal; this module is one, for the arguments of `simulate`."""
    files = (Path(__file__), *(Path(str(module.__file__)) for module in (parameters, simulator)))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _address(gap: float, joint: Joint) -> str:
    parameters = {name: float(value) for name, value in asdict(joint).items()}
    content = json.dumps({"joint": parameters, "half_gap": gap, "sources": _sources()}, sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:24]
