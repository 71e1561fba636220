"""Write recordings and other files whole or not at all, and nothing over what is there unasked."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from bench.errors import BenchError, require

Floats = NDArray[np.float64]

KINDS = (".csv", ".xlsx", ".parquet")
"""The kinds of recording files."""


def check_output(path: Path, kinds: tuple[str, ...], *, force: bool) -> None:
    """Raise BenchError for a file that could not be written, as far as that can be told before it is made.

    Args:
        path: the file.
        kinds: the suffixes it may have.
        force: whether a file that is there may be replaced.
    """
    kind = path.suffix.lower()
    if kind not in kinds:
        raise BenchError(
            f"{path} must end in {' or '.join(', '.join(kinds).rsplit(', ', 1))}, as that is what is written"
        )
    if kind == ".parquet":
        require("pyarrow", "parquet", f"{path} needs")
    if path.exists() and not force:
        raise BenchError(f"{path} is there already; choose another name, or replace it with --force")
    if not path.parent.is_dir():
        raise BenchError(f"{path} cannot be written: there is no folder {path.parent}")


def write_recording(path: Path, time: Floats, speed: Floats) -> None:
    """Write (n,) instants in s and (n,) motor speeds in rps as csv, xlsx or parquet, as the suffix says.

    Raises:
        BenchError: where the file cannot be written.
    """
    columns = {"time_s": time, "speed_rps": speed}
    frame = pd.DataFrame(columns)
    with whole(path) as temporary:
        if path.suffix.lower() == ".csv":
            header = ",".join(columns)
            np.savetxt(temporary, frame.to_numpy(), delimiter=",", header=header, comments="", fmt=["%.6f", "%.10g"])
        elif path.suffix.lower() == ".xlsx":
            frame.to_excel(temporary, index=False)
        else:
            frame.to_parquet(temporary, engine="pyarrow", index=False)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a place beside ``path`` for a file or folder, which takes its place once it is whole.

    After an error nothing is left of it, and what was at ``path`` is there still.

    Raises:
        BenchError: where it cannot be written.
    """
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp{path.suffix}")
    try:
        yield temporary
        if temporary.is_dir() and path.is_dir():
            shutil.rmtree(path)
        temporary.replace(path)
    except OSError as error:
        raise BenchError(f"{path} cannot be written: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            shutil.rmtree(temporary) if temporary.is_dir() else temporary.unlink(missing_ok=True)
