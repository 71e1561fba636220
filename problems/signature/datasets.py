"""The twenty simulated recordings of section 7.2.1, made on first use and kept in the user's cache.

The cache is content-addressed: a file's name is a hash of all that decides its content, the simulator's source
included, so a changed simulator never meets old signals. A file that was damaged is noticed by its checksum and
made again.
"""

import hashlib
import json
import os
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from platformdirs import user_cache_dir

from problems import joint
from problems.joint import Joint, half_gap, simulate

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Dataset:
    """A simulated recording and the truth behind it.

    Attributes:
        time: (2401,) s, from 0.
        speed: (2401,) motor speed in rps.
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


def simulated(gap: float) -> Dataset:
    """Return the default joint's recording at a half-gap in rad, from the cache where it is there and whole."""
    path = cache_folder() / f"joint-{_address(gap)}.npz"
    stored = _read(path)
    if stored is None:
        simulation = simulate(half_gap=gap)
        stored = {"time": simulation.time, "speed": simulation.speed, "peak": np.array([simulation.peak])}
        _write(path, stored)
    return Dataset(stored["time"], stored["speed"], float(stored["peak"][0]), gap)


@cache
def _sources() -> str:
    folder = Path(joint.__file__).parent
    return hashlib.sha256(b"".join(path.read_bytes() for path in sorted(folder.glob("*.py")))).hexdigest()


def _address(gap: float) -> str:
    content = json.dumps({"joint": asdict(Joint()), "half_gap": gap, "sources": _sources()}, sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:24]


def _digest(arrays: dict[str, Floats]) -> str:
    return hashlib.sha256(b"".join(arrays[name].tobytes() for name in sorted(arrays))).hexdigest()


def _read(path: Path) -> dict[str, Floats] | None:
    """Return the arrays of a cache file, or None where it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in ("time", "speed", "peak")}
            return arrays if str(file["digest"]) == _digest(arrays) else None
    except Exception:  # a damaged archive may raise nearly anything; whatever it is, the signal is made again
        return None


def _write(path: Path, arrays: dict[str, Floats]) -> None:
    """Write a cache file at once, so that two workers cannot see each other's half; a read-only cache is no error."""
    temporary = path.with_name(f"{path.stem}.{os.getpid()}.tmp.npz")
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(temporary, allow_pickle=False, digest=np.array(_digest(arrays)), **arrays)
        temporary.replace(path)
