"""What the report of a finished study takes on one core and on all: time, memory, and the size of its page.

    python performance/report.py [FOLDER [ROUNDS]]        # default: results/runs/thesis, 3

The reports are written into temporary folders, in turns; the memory is that of the first, in one process on one core.
All files must be the same.
"""

import resource
import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time

from joblib import cpu_count

from bench import Results, write_report

ROUNDS = 3


def written(folder: Path, jobs: int) -> tuple[float, dict[str, bytes]]:
    """Return the seconds that a report takes, and its files."""
    with tempfile.TemporaryDirectory() as place:
        started = perf_counter()
        write_report(folder, output=place, n_jobs=jobs)
        took = perf_counter() - started
        files = {str(path.relative_to(place)): path.read_bytes() for path in Path(place).rglob("*") if path.is_file()}
    return took, files


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/runs/thesis")
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else ROUNDS
    trials = len(Results(folder).frame)
    processor = process_time()
    one, files = written(folder, 1)
    processor = process_time() - processor
    unit = 1e6 if sys.platform == "darwin" else 1e3  # ru_maxrss is in bytes there, in kilobytes elsewhere
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    times = {1: [one], -1: []}
    for jobs in (-1, *(1, -1) * (rounds - 1)):
        took, again = written(folder, jobs)
        times[jobs].append(took)
        if again != files:
            sys.exit(
                f"other files with {jobs} jobs: {sorted(name for name in files if files[name] != again.get(name))}"
            )
    size = len(files["report.html"]) / 1e6
    alone, together = (min(times[jobs]) for jobs in (1, -1))
    print(
        f"{trials:,} trials: {alone:.1f} s on one core ({processor:.1f} s of processor time in the first), "
        f"{together:.1f} s on {cpu_count()}, the best of {rounds} each"
    )
    print(f"at most {peak:,.0f} MB, a page of {size:.1f} MB")


if __name__ == "__main__":
    main()
