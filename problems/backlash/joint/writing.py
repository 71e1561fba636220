"""Write recordings and other files whole or not at all, and nothing over what is there unasked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from bench.atomic import replacing
from bench.errors import BenchError, require
from bench.problem import Floats

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
    with replacing(path) as temporary:
        if path.suffix.lower() == ".csv":
            header = ",".join(columns)
            np.savetxt(temporary, frame.to_numpy(), delimiter=",", header=header, comments="", fmt=["%.6f", "%.10g"])
        elif path.suffix.lower() == ".xlsx":
            frame.to_excel(temporary, index=False)
        else:
            frame.to_parquet(temporary, engine="pyarrow", index=False)
