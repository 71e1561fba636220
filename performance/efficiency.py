"""Parallel efficiency of the thesis study: one core's time over twice the time of two.

    python performance/efficiency.py [TRIALS] [JOBS]        # default: 10 trials a cell, 2 jobs

Whole commands are timed, with their start and their end, in the order two, one, two jobs, so that a machine that
becomes slower or faster meanwhile counts for neither. Said apart is what the harness has no part in: by how much a
trial itself takes longer while another one runs beside it.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from bench import load_results


def main() -> None:
    trials, jobs = (int(value) for value in (*sys.argv[1:], *("10", "2")[len(sys.argv) - 1 :]))
    with tempfile.TemporaryDirectory() as place:
        first, one, second = (timed(Path(place) / str(turn), trials, n) for turn, n in enumerate((jobs, 1, jobs)))
    many = (first[0] + second[0]) / 2
    beside = (first[1] + second[1]) / 2
    print(f"{one[2]} runs: {one[0]:.1f} s with 1 job, {first[0]:.1f} and {second[0]:.1f} s with {jobs}")
    print(f"parallel efficiency: {one[0] / (jobs * many):.3f}")
    print(f"a trial takes {beside / one[1]:.3f} times as long beside others")


def timed(folder: Path, trials: int, jobs: int) -> tuple[float, float, int]:
    """Run the study; return wall seconds of the command, mean wall seconds of a trial, and their number."""
    began = perf_counter()
    command = ["run", "thesis", "--trials", str(trials), "--jobs", str(jobs), "--output", str(folder), "--no-report"]
    subprocess.run([sys.executable, "-m", "bench", *command], check=True, stdout=subprocess.DEVNULL)
    took = perf_counter() - began
    frame = load_results(folder)
    return took, float(frame["wall_s"].mean()), len(frame)


if __name__ == "__main__":
    main()
