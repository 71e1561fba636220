"""What a short command takes from its start to its end, beside the import of numpy and scipy in the same run.

    python performance/startup.py [ROUNDS]        # default: 7 rounds after a warm-up

Every command is a process of its own; in each round all of them take turns, so that a busy moment of the machine
favours none. Ratios are to the import, best to best and median to median.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

BASELINE = "import numpy, scipy"
COMMANDS = {
    BASELINE: ("-c", BASELINE),
    "bench --help": ("-m", "bench", "--help"),
    "bench list": ("-m", "bench", "list"),
    "bench solve signature-12 gwo": ("-m", "bench", "solve", "signature-12", "gwo", "--budget", "3000"),
    "bench estimate one.xlsx": ("-m", "bench", "estimate", "one.xlsx"),
}


def seconds(arguments: tuple[str, ...], place: Path) -> float:
    """Return the wall seconds of a Python process with those arguments."""
    began = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, cwd=place, stdout=subprocess.DEVNULL)
    return perf_counter() - began


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        seconds(("-m", "bench", "simulate", "one.xlsx", "--level", "12", "--noise", "0.3", "--seed", "1"), place)
        times: dict[str, list[float]] = {name: [] for name in COMMANDS}
        for turn in range(rounds + 1):
            for name, arguments in COMMANDS.items():
                took = seconds(arguments, place)
                if turn:  # the first one compiles and fills caches
                    times[name].append(took)
    baseline = times[BASELINE]
    print(f"{rounds} rounds".ljust(30) + f"{'best':>8}{'median':>9}{'best':>9}{'median':>9}")
    print(" " * 30 + f"{'s':>8}{'s':>9}{'ratio':>9}{'ratio':>9}")
    for name, each in times.items():
        best, middle = min(each), median(each)
        ratios = f"{best / min(baseline):9.2f}{middle / median(baseline):9.2f}"
        print(f"{name:<30}{best:8.3f}{middle:9.3f}{ratios}")


if __name__ == "__main__":
    main()
