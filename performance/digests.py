"""What it takes to notice that a stored trial was changed: the check of a store, and the digest of a committed row.

    python performance/digests.py [TRIALS]        # default: 1,000,000

The rows are those of ``performance/scale.py``: ten evaluations a trial, seven variables, few improvements.
"""

import argparse
import random
import sqlite3
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
import psutil

from bench.objective import Trace
from bench.storage.digests import SEAL
from bench.storage.store import Store, stored
from bench.trial import Trial

CELLS = 200
ROUNDS = 5  # of which the fastest counts: other work on the machine only adds time
COMMITS = 20_000


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("trials", nargs="?", type=int, default=1_000_000)
    trials = parser.parse_args().trials
    with tempfile.TemporaryDirectory() as place:
        check(Store(Path(place)), trials)
    with tempfile.TemporaryDirectory() as place:
        commit(Store(Path(place)))


def check(store: Store, trials: int) -> None:
    """Print what it takes to check a store of so many trials, beside reading its rows without a check."""
    rng = random.Random(1)
    with store.writer() as writer, writer.transaction():
        number = writer.environment({"host": "here"})
        for place in range(trials):
            trial, row = made(rng, place % CELLS, place // CELLS)
            writer.put(stored(trial, row) | {"environment": number})
    size = store.path.stat().st_size
    print(f"{trials:,} trials, {size / 1e6:.0f} MB, {psutil.cpu_count()} cores")
    found = store.check()
    assert found.sound, found.sentence
    assert found.trials == trials
    print(f"check of every row and trace: {fastest(store.check):.2f} s")
    print(f"rows read as dictionaries, without a check: {fastest(lambda: exhaust(store)):.2f} s")
    with sqlite3.connect(store.path) as connection:
        seconds = fastest(lambda: connection.execute("PRAGMA integrity_check").fetchall())
    connection.close()
    print(f"SQLite's own check of the file, which a run makes too: {seconds:.2f} s")


def exhaust(store: Store) -> None:
    for _ in store.rows(traces=True):
        pass


def commit(store: Store) -> None:
    """Print what a committed row takes, and its digest alone."""
    rng = random.Random(2)
    rows = [made(rng, place % CELLS, place // CELLS) for place in range(COMMITS)]
    with store.writer() as writer:
        times = []
        for trial, row in rows:
            began = perf_counter()
            writer.add(trial, row)
            times.append(perf_counter() - began)
        connection = writer._connection
        keys = connection.execute("SELECT cell, trial FROM results").fetchall()
        alone = []
        with connection:
            for key in keys:
                began = perf_counter()
                connection.execute(f"{SEAL} WHERE cell = ? AND trial = ?", key)
                alone.append(perf_counter() - began)
    print(f"a committed row: {1e6 * np.median(times):.0f} us, of them {1e6 * np.median(alone):.0f} us for its digest")


def made(rng: random.Random, cell: int, number: int) -> tuple[Trial, dict[str, object]]:
    """Return a trial and its row."""
    count = rng.randint(1, 4)
    trace = Trace(np.arange(1, count + 1), np.array([rng.random() for _ in range(count)]))
    row = {
        "status": "ok", "fun": rng.random(), "nfev": 10, "wall_s": rng.random(), "cpu_s": rng.random(),
        "objective_s": rng.random(), "stop": "budget", "outside_box": 0,
        "x": {name: rng.random() for name in ("A", "t0", "T1", "T2", "b0", "b1", "b2")},
        "figures": {name: rng.random() for name in ("amplitude_rpm", "amplitude_error_rpm", "backlash_rad")},
        "trace": trace,
    }  # fmt: skip
    return Trial(f"signature-{cell % 20 + 1:02}", f"random-{cell // 20}", number, rng.getrandbits(62)), row


def fastest(task: Callable[[], object]) -> float:
    """Return the seconds of the fastest of several calls."""
    times = []
    for _ in range(ROUNDS):
        began = perf_counter()
        task()
        times.append(perf_counter() - began)
    return min(times)


if __name__ == "__main__":
    main()
