"""What the tidy frame of a study of very many trials takes: seconds and memory, by number of trials.

    taskset -c 0 python performance/frame.py [TRIALS …] [--keep FOLDER]        # default: 250000 500000 1000000

No search is run: the store holds made-up trials of 10 optimizers on the 20 signature problems, as a run would write
them, with seven variables, three metrics and up to four improvements each. Every frame is read in a process of its own,
whose largest resident set is the memory; each trial is compared with its digest.
"""

import argparse
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from bench import Study, Trace
from bench.storage.folder import Folder
from bench.storage.rows import stored
from bench.trial import Trial

CELLS = 200
STUDY = {
    "name": "frame",
    "budget": 10,
    "problems": [{"names": [f"signature-{level:02}" for level in range(1, 21)]}],
    "optimizers": [{"name": "random-search", "label": f"random-{number}", "agents": 10} for number in range(10)],
}
CHILD = """
import resource, sys, time
import pandas, bench.storage.results
unit = 1e6 if sys.platform == "darwin" else 1e3
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
began, cpu = time.perf_counter(), time.process_time()
frame = bench.storage.results.load_results(sys.argv[1])
wall, cpu = time.perf_counter() - began, time.process_time() - cpu
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
held = frame.memory_usage(deep=True).sum() / 1e6
print(f"{len(frame):>9,} trials: {wall:5.1f} s ({cpu:.1f} s of processor time), "
      f"at most {peak:,.0f} MB ({before:,.0f} MB before), a frame of {held:,.0f} MB")
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trials", nargs="*", type=int, default=[250_000, 500_000, 1_000_000])
    parser.add_argument("--keep", type=Path, help="make the stores in this folder, or take those that are there")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        for trials in chosen.trials:
            folder = (chosen.keep or Path(place)) / str(trials)
            if not (folder / "trials.sqlite").exists():
                make(Folder(folder), trials)
            print(f"{trials:>9,} trials: a store of {(folder / 'trials.sqlite').stat().st_size / 1e6:,.0f} MB")
            subprocess.run([sys.executable, "-c", CHILD, str(folder)], check=True)


def make(folder: Folder, trials: int) -> None:
    """Write a study's folder of so many made-up trials; the same every time."""
    folder.path.mkdir(parents=True)
    folder.claim(Study.from_dict(STUDY | {"trials": max(trials // CELLS, 1)}))
    rng = random.Random(1)
    with folder.store.writer() as writer, writer.transaction():
        number = writer.environment({"host": "here"})
        for place in range(trials):
            trial, row = made(rng, place % CELLS, place // CELLS)
            writer.put(stored(trial, row) | {"environment": number})


def made(rng: random.Random, cell: int, number: int) -> tuple[Trial, dict[str, object]]:
    """Return a trial and its row."""
    count = rng.randint(1, 4)
    trace = Trace(np.arange(1, count + 1), np.array([rng.random() for _ in range(count)]))
    row = {
        "status": "ok", "fun": rng.random(), "nfev": 10, "wall_s": rng.random(), "cpu_s": rng.random(),
        "objective_s": rng.random(), "stop": "budget", "outside_box": 0,
        "x": {name: rng.random() for name in ("A", "t0", "T1", "T2", "b0", "b1", "b2")},
        "metrics": {name: rng.random() for name in ("amplitude_rpm", "amplitude_error_rpm", "backlash_rad")},
        "trace": trace,
    }  # fmt: skip
    return Trial(f"signature-{cell % 20 + 1:02}", f"random-{cell // 20}", number, rng.getrandbits(62)), row


if __name__ == "__main__":
    main()
