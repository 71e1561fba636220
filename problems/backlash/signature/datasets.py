"""Simulate recordings, such as the twenty of section 7.2.1, on first use and keep them in the user's cache.

The cache is content-addressed: a file's name is a hash of everything that determines its content, the simulator's
source included, so a changed simulator never reads old signals. A damaged file is detected by its checksum and
replaced.
"""

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from platformdirs import user_cache_dir

from bench.atomic import replacing
from bench.errors import BenchError
from bench.problem import Floats
from problems.backlash.joint import Joint, half_gap, simulate
from problems.backlash.joint import parameters as joint_parameters
from problems.backlash.joint import simulator as joint_simulator

DEFAULT = Joint()


@dataclass(frozen=True, eq=False)
class Dataset:
    """A simulated recording and the truth behind it.

    Attributes:
        time: (n,) s, from 0; 2401 samples at 500 Hz, or two load turns if these take longer.
        speed: (n,) motor speed in rps.
        peak: expected amplitude in rps: the positive peak of the undecimated disturbance.
        half_gap: delta in rad.
    """

    time: Floats
    speed: Floats
    peak: float
    half_gap: float


def cache_folder() -> Path:
    """Return the folder of cached signals: ``$BENCH_CACHE``, or the user's cache directory."""
    return Path(os.environ.get("BENCH_CACHE") or user_cache_dir("backlash-bench"))


@cache
def dataset(level: int) -> Dataset:
    """Return the recording of a level 1 … 20; raises BenchError outside."""
    return simulated(half_gap(level))


def simulated(gap: float, joint: Joint = DEFAULT) -> Dataset:
    """Return a joint's recording at a half-gap in rad, from the cache if it is there and undamaged.

    Raises:
        BenchError: as :func:`problems.backlash.joint.simulate`.
    """
    path = cache_folder() / f"joint-{_address(gap, joint)}.npz"
    stored = _read(path)
    if stored is None:
        simulation = simulate(joint, half_gap=gap, duration=max(4.8, 2 * joint.turn))
        stored = {"time": simulation.time, "speed": simulation.speed, "peak": np.array([simulation.peak])}
        _write(path, stored)
    return Dataset(stored["time"], stored["speed"], float(stored["peak"][0]), gap)


@cache
def _sources() -> str:
    """Return a hash of the modules that determine a signal; this module is one, for the arguments of `simulate`."""
    files = (Path(__file__), *(Path(str(module.__file__)) for module in (joint_parameters, joint_simulator)))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def _address(gap: float, joint: Joint) -> str:
    parameters = {name: float(value) for name, value in asdict(joint).items()}
    content = json.dumps({"joint": parameters, "half_gap": gap, "sources": _sources()}, sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:24]


def _digest(arrays: dict[str, Floats]) -> str:
    return hashlib.sha256(b"".join(arrays[name].tobytes() for name in sorted(arrays))).hexdigest()


def _read(path: Path) -> dict[str, Floats] | None:
    """Return the arrays of a cache file, or None where it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in ("time", "speed", "peak")}
            return arrays if str(file["digest"]) == _digest(arrays) else None
    except Exception:  # a damaged archive may raise nearly anything; the signal is made again
        return None


def _write(path: Path, arrays: dict[str, Floats]) -> None:
    """Write a cache file atomically, so that no worker reads half of it; a read-only cache is not an error."""
    with suppress(OSError, BenchError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            np.savez(temporary, allow_pickle=False, digest=np.array(_digest(arrays)), **arrays)
