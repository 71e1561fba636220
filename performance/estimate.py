"""Time ``bench estimate`` on a folder of xlsx recordings, with confidence intervals, as one command.

    python performance/estimate.py [RECORDINGS] [--jobs N]        # default: 100, on every core

Each recording is a simulated joint of another level (section 7.2.1) with the low noise of section 7.3. The seconds are
of the whole command, start-up included.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import pandas as pd

from problems.backlash.signature.datasets import noisy


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="?", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=-1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        for number in range(options.recordings):
            made = noisy(2 + number % 19, "low", number)
            frame = pd.DataFrame({"time": made.time, "speed": made.speed})
            frame.to_excel(Path(place) / f"joint-{number:03}.xlsx", index=False)
        size = sum(each.stat().st_size for each in Path(place).iterdir()) / options.recordings
        command = [sys.executable, "-m", "bench", "estimate", place, "--json", "--jobs", str(options.jobs)]
        started = perf_counter()
        found = subprocess.run(command, stdout=subprocess.PIPE, check=True)
        seconds = perf_counter() - started
    answers = json.loads(found.stdout)
    assert len(answers) == options.recordings
    print(f"{len(answers)} recordings of {size / 1e3:.0f} kB: {seconds:.1f} s, {seconds / len(answers):.3f} s each")


if __name__ == "__main__":
    main()
