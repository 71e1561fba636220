"""Measure everything that docs/reference/performance.md shows, and write docs/reference/performance.json.

    python performance              # about ten minutes on two idle cores; 'nox -s performance' does it
    python performance --quick      # small sizes, to try the scripts: the file is marked, and so is the page

Each script runs alone, one after the other, in a process of its own.
"""

import argparse
import json
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import distributions
from pathlib import Path
from time import monotonic

from bench.storage.provenance import machine

HERE = Path(__file__).resolve().parent
RESULT = HERE.parent / "docs" / "reference" / "performance.json"
PACKAGES = ("numpy", "scipy", "pandas", "numba", "matplotlib", "joblib", "mealpy", "ioh", "coco-experiment")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    rows = []
    for script in sorted(HERE.glob("[a-z]*.py")):
        began = monotonic()
        command = [sys.executable, str(script), "--json", *(["--quick"] if quick else [])]
        done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
        if done.returncode:
            sys.exit(f"{script.name} ended with {done.returncode}; nothing is written")
        found = json.loads(done.stdout.splitlines()[-1])
        rows += found
        print(f"{script.name}: {len(found)} rows in {monotonic() - began:.0f} s", flush=True)
    RESULT.write_text(json.dumps(record(quick) | {"rows": rows}, indent=1) + "\n", encoding="utf-8")


def record(quick: bool) -> dict[str, object]:
    """Return when, where and of which code the rows are."""
    here = machine()
    installed = {distribution.name: distribution.version for distribution in distributions()}
    packages = {name: installed[name] for name in PACKAGES if name in installed}
    known = {key: here[key] for key in ("processor", "cores", "memory_gb", "system", "python", "git")}
    return {"quick": quick, "date": datetime.now(UTC).date().isoformat(), **known, "packages": packages}


if __name__ == "__main__":
    main()
