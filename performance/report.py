"""What the report of a finished study takes: time, memory, and the size of its page.

    python performance/report.py [FOLDER]        # default: results/runs/thesis

The report is written into a temporary folder, in one process on one core.
"""

import resource
import sys
import tempfile
from pathlib import Path
from time import perf_counter

from bench import Results, write_report


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/runs/thesis")
    trials = len(Results(folder).frame)
    with tempfile.TemporaryDirectory() as place:
        started = perf_counter()
        page = write_report(folder, output=place)
        took = perf_counter() - started
        size = page.stat().st_size / 1e6
    unit = 1e6 if sys.platform == "darwin" else 1e3  # ru_maxrss is in bytes there, in kilobytes elsewhere
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    print(f"{trials:,} trials: {took:.1f} s, at most {peak:,.0f} MB, a page of {size:.1f} MB")


if __name__ == "__main__":
    main()
