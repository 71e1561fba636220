"""Time ``bench estimate`` on a folder of xlsx recordings, with confidence intervals, as one command.

Each recording is a simulated joint of another level (section 7.2.1) with the low noise of section 7.3. The seconds are
of the whole command, which uses every core, start-up included.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import pandas as pd
from _rows import Rows, main, short
from joblib import cpu_count

from problems.backlash.signature.datasets import noisy


def measure(quick: bool) -> Rows:
    recordings = 3 if quick else 100
    with tempfile.TemporaryDirectory() as place:
        for number in range(recordings):
            made = noisy(2 + number % 19, "low", number)
            frame = pd.DataFrame({"time": made.time, "speed": made.speed})
            frame.to_excel(Path(place) / f"joint-{number:03}.xlsx", index=False)
        took = seconds(place, recordings)
    value = f"{short(took)} s on {cpu_count()} cores, {short(took / recordings)} s each"
    return [(f"`bench estimate` on {recordings} xlsx recordings, with intervals", value)]


def seconds(place: str, recordings: int) -> float:
    """Return the wall seconds of the command."""
    command = [sys.executable, "-m", "bench", "estimate", place, "--json"]
    began = perf_counter()
    found = subprocess.run(command, stdout=subprocess.PIPE, check=True)
    took = perf_counter() - began
    if len(json.loads(found.stdout)) != recordings:
        sys.exit("not every recording was estimated")
    return took


if __name__ == "__main__":
    main(measure)
