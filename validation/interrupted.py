"""Kill a run of a simulator at random moments, go on with it, and count the simulator's evaluations.

Four jobs evaluate four points at a time. The evaluations in all are to be those of a run that nobody interrupts, plus
at most those that were under way at each kill: python validation/interrupted.py [KILLS] [SEED]
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep

import bench

JOBS, PARALLEL, BUDGET, TRIALS = 4, 4, 60, 2
TIMES = ["wall_s", "cpu_s", "objective_s", "memory_mb"]
SIMULATOR = """#!/bin/sh
echo "$1 $2" >> COUNT
sleep 0.3
awk -v x="$1" -v y="$2" 'BEGIN { printf "%.17g %.17g\\n", (x - 1) ^ 2 + y ^ 2, 0.2 - y }'
echo "$1 $2" >> COUNT.ended
"""
STUDY = f"""
name = "interrupted"
trials = {TRIALS}
budget = {BUDGET}
parallel = {PARALLEL}
[[problems]]
problem = ["SIMULATOR"]
label = "simulator"
lower = [0, 0]
upper = [2, 1]
violations = 1
[[optimizers]]
name = "random-search"
[[optimizers]]
name = "cma-es"
"""


def start(study: Path, output: Path) -> subprocess.Popen[bytes]:
    """Start the run of the study in a process."""
    code = f"import bench; bench.run({str(study)!r}, {str(output)!r}, n_jobs={JOBS})"
    return subprocess.Popen([sys.executable, "-c", code], start_new_session=True)


def main(kills: int, seed: int) -> int:
    """Print the evaluations of an interrupted run beside those of one that nobody interrupts; return an exit code."""
    draw = random.Random(seed)
    with TemporaryDirectory() as place:
        folder, count = Path(place), Path(place, "count")
        simulator = folder / "simulator.sh"
        simulator.write_text(SIMULATOR.replace("COUNT", str(count)))
        simulator.chmod(0o755)
        study = folder / "study.toml"
        study.write_text(STUDY.replace("SIMULATOR", str(simulator)))
        counts = {}
        for name in ("whole", "interrupted"):
            for file in (count, Path(f"{count}.ended")):
                file.unlink(missing_ok=True)
            made = under_way = lost = 0
            while name == "interrupted" and made < kills:
                before, wanted = lines(count), draw.randrange(1, 2 * 4 * TRIALS * BUDGET // (2 * kills))
                process, pause = start(study, folder / name), draw.random()
                began = monotonic()
                while lines(count) < before + wanted and process.poll() is None and monotonic() - began < 300:
                    sleep(0.01)
                sleep(pause * 0.3)
                if process.poll() is not None:  # the run has ended before this kill
                    break
                under_way += lines(count) - lines(Path(f"{count}.ended")) - lost
                os.kill(process.pid, signal.SIGKILL)
                process.wait()
                sleep(1)  # the evaluations under way end, or were killed, too
                lost = lines(count) - lines(Path(f"{count}.ended"))
                made += 1
                print(f"kill {made}: {lines(count)} evaluations", flush=True)
            start(study, folder / name).wait()
            counts[name] = lines(count)
        frames = [bench.load_results(folder / name).drop(columns=TIMES) for name in counts]
        twice = counts["interrupted"] - counts["whole"]
        most = made * JOBS * PARALLEL
        print(f"evaluations: {counts}, killed {made} times")
        print(f"{twice} more; {under_way} were under way when it was killed, and {most} may have been")
        print(f"the same trials bit by bit: {frames[0].equals(frames[1])}")
        return 0 if frames[0].equals(frames[1]) and 0 <= twice <= most else 1


def lines(count: Path) -> int:
    """Return the evaluations of the simulator so far."""
    return count.read_bytes().count(b"\n") if count.exists() else 0


if __name__ == "__main__":
    sys.exit(main(*map(int, (*sys.argv[1:], *("20", "1")[len(sys.argv) - 1 :]))))
