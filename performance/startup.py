"""What a short command takes from its start to its end, beside the import of numpy and scipy in the same run.

Every command is a process of its own; in each round all of them take turns, so that a busy moment of the machine
favours none. Medians of the rounds after a warm-up.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import pandas as pd
from _rows import Rows, main, short, times

BASELINE = "import numpy, scipy"
COMMANDS = {
    "bench --help": ("-m", "bench", "--help"),
    "bench list": ("-m", "bench", "list"),
    "bench solve signature-12 gwo --budget 3000": ("-m", "bench", "solve", "signature-12", "gwo", "--budget", "3000"),
    "bench estimate one.xlsx": ("-m", "bench", "estimate", "one.xlsx"),
}
SIMULATE = ("-m", "bench", "simulate", "one.csv", "--level", "12", "--noise", "0.3", "--seed", "1")


def measure(quick: bool) -> Rows:
    rounds = 1 if quick else 7
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        seconds(SIMULATE, place)
        pd.read_csv(place / "one.csv").to_excel(place / "one.xlsx", index=False)
        turns = [
            {name: seconds(arguments, place) for name, arguments in {BASELINE: ("-c", BASELINE), **COMMANDS}.items()}
            for _ in range(rounds + 1)
        ][1:]  # the first one compiles and fills caches
    rows = []
    for name in COMMANDS:
        ratio = median(turn[name] / turn[BASELINE] for turn in turns)
        value = f'{times(ratio)} `python -c "{BASELINE}"`: {short(median(turn[name] for turn in turns))} s'
        rows.append((f"`{name}`, from start to end", value))
    return rows


def seconds(arguments: tuple[str, ...], place: Path) -> float:
    """Return the wall seconds of a Python process with those arguments."""
    began = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, cwd=place, stdout=subprocess.DEVNULL)
    return perf_counter() - began


if __name__ == "__main__":
    main(measure)
