"""What a study of very many trials takes: memory of the parent while it runs, overhead a trial, and reading it back.

    python performance/scale.py [TRIALS] [--keep FOLDER]        # default: 1,000,000

The objective is all but free (ten evaluations a trial, 0.1 us each), so that what is measured is the harness: dispatch,
the trial's own process, and a committed row. The parent's memory is its resident set.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic, perf_counter, sleep

import psutil

CELLS = 200
STUDY = """
name = "scale"
trials = {trials}
budget = 10

[[problems]]
names = [{problems}]

{optimizers}
"""


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("trials", nargs="?", type=int, default=1_000_000)
    parser.add_argument("--keep", type=Path)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = chosen.keep or Path(place) / "scale"
        measure(folder, chosen.trials // CELLS)


def measure(folder: Path, trials: int) -> None:
    """Run the study into a folder, and print what it takes."""
    problems = ", ".join(f'"signature-{level:02}"' for level in range(1, 21))
    optimizers = "\n".join(
        f'[[optimizers]]\nname = "random-search"\nlabel = "random-{number}"\nagents = 10\n'
        for number in range(CELLS // 20)
    )
    folder.parent.mkdir(parents=True, exist_ok=True)
    path = folder.with_suffix(".toml")
    path.write_text(STUDY.format(trials=trials, problems=problems, optimizers=optimizers))
    wall, held, cpu = run([sys.executable, "-m", "bench", "run", str(path), "--output", str(folder), "--no-report"])
    total, jobs = trials * CELLS, psutil.cpu_count()
    tenths = [max(held[index * len(held) // 10 : (index + 1) * len(held) // 10]) for index in range(10)]
    print(f"{total:,} trials in {wall:.0f} s with {jobs} jobs: {1e3 * wall / total:.3f} ms a trial")
    print(f"of them {1e3 * cpu / total:.3f} ms of the parent's processor")
    print("parent's memory in each tenth of the run (MB): " + ", ".join(f"{each / 1e6:.0f}" for each in tenths))
    size = sum(each.stat().st_size for each in folder.glob("trials.sqlite*"))
    print(f"store: {size / 1e6:.0f} MB, {size / total:.0f} bytes a trial")
    for command in (["status", str(folder)], ["run", str(path), "--output", str(folder), "--dry-run"]):
        wall, held, _ = run([sys.executable, "-m", "bench", *command])
        print(f"bench {command[0]}{' --dry-run' if len(command) > 2 else ''}: {wall:.1f} s, {max(held) / 1e6:.0f} MB")
    code = f"import bench; frame = bench.load_results({str(folder)!r}); assert len(frame) == {total}"
    wall, held, _ = run([sys.executable, "-c", code])
    print(f"the tidy frame: {wall:.1f} s, {max(held) / 1e6:.0f} MB")


def run(command: list[str]) -> tuple[float, list[int], float]:
    """Return a command's wall seconds, its resident memory in bytes, ten times a second, and its processor seconds."""
    started, cpu = perf_counter(), 0.0
    process = psutil.Popen(command, stdout=subprocess.DEVNULL)
    held, spoken = [], monotonic()
    while process.poll() is None:
        try:
            held.append(process.memory_info().rss)
            times = process.cpu_times()
            cpu = times.user + times.system
        except psutil.Error:
            break
        if monotonic() - spoken > 60:
            spoken = monotonic()
            print(f"  … {held[-1] / 1e6:.0f} MB after {perf_counter() - started:.0f} s", flush=True)
        sleep(0.1)
    if process.wait():
        raise SystemExit(f"{' '.join(command)} failed")
    return perf_counter() - started, held, cpu


if __name__ == "__main__":
    main()
