"""What all scripts of this folder share: their command line, a process apart, and short numbers.

A script has one function ``measure(quick)``, which returns what it measured as pairs of texts: what, and its value with
a unit. ``quick`` makes everything small: it shows that the script works, and its numbers mean nothing.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

Rows = list[tuple[str, str]]

APART = """
import json, resource, sys, time
{imports}
unit = 1e6 if sys.platform == "darwin" else 1e3  # ru_maxrss is in bytes there, in kilobytes elsewhere
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
wall, cpu = time.perf_counter(), time.process_time()
{code}
wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
print(json.dumps([wall, cpu, before, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit]))
"""


class Cost(NamedTuple):
    """What code took in a process of its own: seconds, processor seconds, and the memory before and at its peak."""

    wall_s: float
    cpu_s: float
    before_mb: float
    peak_mb: float


def apart(imports: str, code: str, *arguments: str) -> Cost:
    """Return what code takes in a process of its own, which has the arguments in ``sys.argv``; imports do not count."""
    command = [sys.executable, "-c", APART.format(imports=imports, code=code), *arguments]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    return Cost(*json.loads(done.stdout.splitlines()[-1]))


def short(number: float) -> str:
    """Return a number with two significant digits, and none left out before the point: 0.093, 1.6, 439 as "440"."""
    return np.format_float_positional(number, precision=2, unique=False, fractional=False, trim="-")


def times(number: float) -> str:
    """Return a ratio as text, such as "1.6 times"."""
    return f"{short(number)} times"


def growth(before: str, now: str) -> float:
    """Return the largest ratio of the times and sizes in two values of one row; 1 where these are of other kinds."""
    measured = [re.findall(r"([\d.,]*\d) (s|ms|us|MB|bytes)\b", value) for value in (before, now)]
    units = [[unit for _, unit in each] for each in measured]
    if units[0] != units[1]:
        return 1.0
    pairs = zip(*([float(number.replace(",", "")) for number, _ in each] for each in measured), strict=True)
    return max((new / old for old, new in pairs if old), default=1.0)


def main(measure: Callable[[bool], Rows]) -> None:
    """Print what a script measures, as text or, with ``--json``, for the runner."""
    about = sys.modules["__main__"].__doc__
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="small sizes, to try the script")
    parser.add_argument("--json", action="store_true", help="print JSON")
    chosen = parser.parse_args()
    name = Path(sys.argv[0]).stem
    rows = [
        {"script": name, "measured": what, "value": value, "command": f"python performance/{name}.py"}
        for what, value in measure(chosen.quick)
    ]
    if chosen.json:
        print(json.dumps(rows))
    else:
        for row in rows:
            print(f"{row['measured']}: {row['value']}")
