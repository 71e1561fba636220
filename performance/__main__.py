"""Measure everything that docs/reference/performance.md shows, and write docs/reference/performance.json.

    python performance              # about ten minutes on two idle cores; 'nox -s performance' does it
    python performance --quick      # small sizes, to try the scripts: the file is marked, and so is the page

Each script runs alone, one after the other, in a process of its own. Each row is printed with the committed one; the
rows whose time or memory grew to 1.3 times or more are named at the end. Where the machine was busy when it began, the
page says so.
"""

import argparse
import json
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import distributions
from os import getloadavg
from pathlib import Path
from time import monotonic

from _rows import growth

from bench.storage.provenance import machine

HERE = Path(__file__).resolve().parent
RESULT = HERE.parent / "docs" / "reference" / "performance.json"
GROWN = 1.3  # times the committed time or memory
PACKAGES = ("numpy", "scipy", "pandas", "numba", "matplotlib", "joblib", "mealpy", "ioh", "coco-experiment")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    known, rows, grown = committed(quick), [], []
    about = record(quick)
    for script in sorted(HERE.glob("[a-z]*.py")):
        began = monotonic()
        command = [sys.executable, str(script), "--json", *(["--quick"] if quick else [])]
        done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
        if done.returncode:
            sys.exit(f"{script.name} ended with {done.returncode}; nothing is written")
        found = json.loads(done.stdout.splitlines()[-1])
        rows += found
        print(f"{script.name}: {len(found)} rows in {monotonic() - began:.0f} s", flush=True)
        for row in found:
            before = known.get(row["measured"], "")
            print(f"  {row['measured']}: {row['value']}" + f" (committed: {before})" * bool(before), flush=True)
            if (times := growth(before, row["value"])) >= GROWN:
                grown.append(f"{times:.1f} times the committed one: {row['measured']}")
    RESULT.write_text(json.dumps(about | {"rows": rows}, indent=1) + "\n", encoding="utf-8")
    if known:
        print("\n".join(grown or [f"nothing is {GROWN} times slower or larger than the committed rows"]))


def committed(quick: bool) -> dict[str, str]:
    """Return the committed value of each row; empty outside a checkout, and where its sizes were others."""
    place = f"HEAD:./{RESULT.name}"
    done = subprocess.run(["git", "show", place], cwd=RESULT.parent, capture_output=True, check=False)
    before = json.loads(done.stdout or "{}")
    return {row["measured"]: row["value"] for row in before.get("rows", ()) if before["quick"] == quick}


def record(quick: bool) -> dict[str, object]:
    """Return when, where and of which code the rows are."""
    here = machine()
    installed = {distribution.name: distribution.version for distribution in distributions()}
    packages = {name: installed[name] for name in PACKAGES if name in installed}
    known = {key: here[key] for key in ("processor", "cores", "memory_gb", "system", "python", "git")}
    return {
        "quick": quick,
        "date": datetime.now(UTC).date().isoformat(),
        "load": round(getloadavg()[0], 1),
        **known,
        "packages": packages,
    }


if __name__ == "__main__":
    main()
