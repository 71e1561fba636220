"""Check output paths and write recordings, whole or not at all; replace an existing file only on request."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench.contract.typing import Floats
from bench.helpers import replacing
from bench.helpers.errors import BenchError


def check_output(path: Path, kind: str, *, force: bool) -> None:
    """Raise BenchError for a file that cannot be written, as far as a check before the work can detect it.

    It must end in ``kind``; with ``force`` it may exist.
    """
    if path.suffix.lower() != kind:
        raise BenchError(f"{path} must end in {kind}, the kind that can be written")
    if path.exists() and not force:
        raise BenchError(f"{path} is there already; choose another name, or replace it with --force")
    check_folder(path)


def check_folder(path: Path) -> None:
    """Raise BenchError for a path in a folder that does not exist."""
    if not path.parent.is_dir():
        raise BenchError(f"{path} cannot be written: there is no folder {path.parent}")


def write_recording(path: Path, time: Floats, speed: Floats, **others: Floats) -> None:
    """Write (n,) instants in s and (n,) motor speeds in rps as csv; ``others`` are further columns (n,), by heading."""
    columns = {"time_s": time, "speed_rps": speed, **others}
    rows, formats = np.column_stack(list(columns.values())), ["%.6f"] + ["%.10g"] * (len(columns) - 1)
    with replacing(path) as temporary:
        np.savetxt(temporary, rows, fmt=formats, delimiter=",", header=",".join(columns), comments="")
