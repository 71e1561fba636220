"""What the tidy frame of a study of very many trials takes: seconds and memory; and the size of its store.

No search is run: the store holds made-up trials of 10 optimizers on the 20 signature problems, as a run would write
them, with seven variables, three metrics and up to four improvements each. The frame is read in a process of its own,
and each trial is compared with its digest.
"""

import random
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from _rows import Rows, apart, main, short
from scale import OPTIMIZERS, PROBLEMS, STUDY

from bench import Study, Trace
from bench.storage.folder import Folder
from bench.trial.columns import packed
from bench.trial.trial import Trial

TRIALS = 250_000
CELLS = PROBLEMS * OPTIMIZERS


def measure(quick: bool) -> Rows:
    trials = 2_000 if quick else TRIALS
    with tempfile.TemporaryDirectory() as place:
        folder = Folder(Path(place) / "frame")
        make(folder, trials)
        size = (folder.path / "trials.sqlite").stat().st_size
        frame = apart(
            "import pandas, bench.results.results", "bench.results.results.load_results(sys.argv[1])", str(folder.path)
        )
        began = perf_counter()
        subprocess.run(
            [sys.executable, "-m", "bench", "status", str(folder.path)], check=True, stdout=subprocess.DEVNULL
        )
        status = perf_counter() - began
    read = (
        f"{short(frame.cpu_s)} s of processor time, {short(1e6 * frame.cpu_s / trials)} us a trial; at most "
        f"{frame.peak_mb:.0f} MB, {frame.before_mb:.0f} MB of them before"
    )
    return [
        (f"tidy frame of {trials:,} trials, digests included", read),
        (f"`bench status` of {trials:,} trials", f"{short(status)} s"),
        ("store of these trials, a trial, with up to four improvements each", f"{size / trials:.0f} bytes"),
    ]


def make(folder: Folder, trials: int) -> None:
    """Write a study's folder of so many made-up trials; the same every time."""
    folder.path.mkdir(parents=True)
    folder.claim(Study.from_dict(STUDY | {"trials": trials // CELLS}))
    rng = random.Random(1)
    with folder.store.writer() as writer, writer.transaction():
        number = writer.record("environments", {"host": "here"})
        for place in range(trials):
            trial, row = made(rng, place % CELLS, place // CELLS)
            writer.put(packed(row) | trial.columns | {"environment": number})


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
    main(measure)
