"""What a study of very many trials takes: time a trial, the memory of the parent while it runs, and the store.

The objective is all but free (ten evaluations a trial, 0.1 us each), so that what is measured is the harness: dispatch,
the trial's own process, and a committed row. The parent's memory is its resident set, which grows by the key of each
finished trial (180 bytes). A larger TRIALS shows that the time does not grow.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, sleep

import psutil
from _rows import Rows, main, short

from bench import Study

TRIALS = 20_000
PROBLEMS, OPTIMIZERS = 20, 10
STUDY = {
    "name": "scale",
    "budget": 10,
    "problems": [{"names": [f"signature-{level:02}" for level in range(1, PROBLEMS + 1)]}],
    "optimizers": [{"name": "random-search", "label": f"random-{n}", "agents": 10} for n in range(OPTIMIZERS)],
}


def measure(quick: bool) -> Rows:
    trials = 400 if quick else TRIALS
    with tempfile.TemporaryDirectory() as place:
        path, folder = Path(place) / "scale.toml", Path(place) / "scale"
        path.write_text(Study.from_dict(STUDY | {"trials": trials // (PROBLEMS * OPTIMIZERS)}).to_toml())
        wall, cpu, held = watched("run", str(path), "--output", str(folder), "--shard", "1/1")  # no answer
        size = sum(each.stat().st_size for each in folder.glob("trials.sqlite*"))
    tenths = [max(held[index * len(held) // 10 : (index + 1) * len(held) // 10]) / 1e6 for index in range(10)]
    each = f"{short(1e3 * wall / trials)} ms, {short(1e3 * cpu / trials)} ms of it processor time of the parent"
    return [
        (f"a trial of ten evaluations with {psutil.cpu_count()} jobs, {trials:,} in a run, start-up included", each),
        (
            "memory of the parent in the first and the last tenth of this run",
            f"{tenths[0]:.0f} and {tenths[-1]:.0f} MB",
        ),
        ("store of this run, a trial", f"{size / trials:.0f} bytes"),
    ]


def watched(*arguments: str) -> tuple[float, float, list[int]]:
    """Return a bench command's wall and processor seconds, and its resident memory in bytes, ten times a second."""
    began, cpu, held = perf_counter(), 0.0, []
    process = psutil.Popen([sys.executable, "-m", "bench", *arguments], stdout=subprocess.DEVNULL)
    while process.poll() is None:
        try:
            held.append(process.memory_info().rss)
            used = process.cpu_times()
            cpu = used.user + used.system
        except psutil.Error:
            break
        sleep(0.1)
    if process.wait():
        sys.exit(f"bench {' '.join(arguments)} failed")
    return perf_counter() - began, cpu, held


if __name__ == "__main__":
    main(measure)
