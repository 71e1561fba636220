"""Compare the numbers of two reports of the same trials: ``python validation/same_numbers.py OLD NEW [OLD NEW …]``.

The tables of a report change with the harness; medians, A12, p-values on single problems, Kolmogorov-Smirnov tests,
expected running times and AOCC do not. The script joins the tables of both folders by their cells and prints, for each
number, how many values both have and how many differ by more than a relative 1e-12. It ends with exit code 1 where any
does.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

CELL, PAIR = ["problem", "optimizer"], ["problem", "first", "second"]
NUMBERS = {
    "tests": (PAIR, ["n_first", "n_second", "a12", "a12_low", "a12_high", "p", "ks_distance", "ks_p"]),
    "running-times": ([*CELL, "target"], ["trials", "successes", "ert", "low", "high", "p10", "p90", "ert_per_d"]),
    "aocc": (CELL, ["aocc", "aocc_from_zero"]),
}
TARGETS = ("budget / d", "tau", "precision", "target", "length")


def read(folder: Path, name: str) -> pd.DataFrame:
    """Return a table, with the column of its targets called target; empty where the report has none."""
    file = folder / "tables" / f"{name}.csv"
    if not file.exists():
        return pd.DataFrame()
    table = pd.read_csv(file)
    unit = [column for column in TARGETS if column in table]
    return table.rename(columns={unit[0]: "target"}) if unit else table


def medians(folder: Path) -> pd.DataFrame:
    """Return the median of each cell, which the comparison once called value."""
    table = read(folder, "comparison")
    return table.rename(columns={"value": "median"})[[*CELL, "median"]]


def differing(old: pd.DataFrame, new: pd.DataFrame, keys: list[str], number: str) -> tuple[int, int]:
    """Return how many values both tables have, and how many of them differ."""
    if number not in old or number not in new:
        return 0, 0
    both = old[[*keys, number]].merge(new[[*keys, number]], on=keys, suffixes=("_old", "_new"))
    one, two = (both[f"{number}_{side}"].to_numpy(dtype=float) for side in ("old", "new"))
    return len(both), int((~np.isclose(one, two, rtol=1e-12, atol=0, equal_nan=True)).sum())


def main() -> int:
    """Print a line a number and pair of folders."""
    folders = [Path(word) for word in sys.argv[1:]]
    if not folders or len(folders) % 2:
        sys.exit("name the folders of two reports, OLD NEW, or of several pairs")
    wrong = 0
    for old, new in zip(folders[::2], folders[1::2], strict=True):
        rows = [("median", *differing(medians(old), medians(new), CELL, "median"))]
        for table, (keys, numbers) in NUMBERS.items():
            both = read(old, table), read(new, table)
            rows += [(f"{table}: {number}", *differing(*both, keys, number)) for number in numbers]
        for name, values, unlike in rows:
            if values:
                print(f"{new.name:14} {name:28} {values:7,} values, {unlike:,} differ")
        wrong += sum(unlike for *_, unlike in rows)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
