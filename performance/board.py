"""Measure how long a board over 100 archives of bbob-quick takes.

The archives have the study's problems and optimizers, each its own seed, and trials that are filled by hand: values by
chance, and a trace of 30 improvements. They are as large as real ones, and nothing of a board depends on the values.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from _rows import Rows, apart, main, short

from bench import Study
from bench.columns import packed
from bench.formats.archive import pack
from bench.objective import Trace
from bench.storage.folder import Folder

ARCHIVES = 100
IMPROVEMENTS = 30


def measure(quick: bool) -> Rows:
    number = 2 if quick else ARCHIVES
    with tempfile.TemporaryDirectory() as place:
        study = Study.load("bbob-quick")
        files = [str(archive(Path(place, f"quick-{seed:03}"), study.override(seed=seed))) for seed in range(number)]
        code = "write_board([Path(each) for each in sys.argv[2:]], Path(sys.argv[1]))"
        imports = "from pathlib import Path\nfrom bench.board import write_board"
        found = apart(imports, code, str(Path(place, "board")), *files)
    return [(f"`bench site` of {number} archives of bbob-quick, of 1,800 trials each", f"{short(found.wall_s)} s")]


def archive(path: Path, study: Study) -> Path:
    """Write a study's folder of trials that are filled by hand, and return its archive."""
    folder, rng = Folder(path), np.random.default_rng(study.seed)
    path.mkdir()
    folder.claim(study)
    with folder.store.writer() as writer:
        environment = writer.environment({"python": sys.version.split()[0], "ended": "2026-01-01T00:00:00+00:00"})
        for trial in study.plan():
            values = np.sort(rng.normal(size=IMPROVEMENTS))[::-1]
            writer.add(trial, packed(row(values, int(trial.problem.split("-d")[1].split("-")[0]))), environment)
    folder.write_environments()
    return pack(path).path


def row(values: np.ndarray, dimension: int) -> dict[str, object]:
    return {
        "status": "ok", "fun": float(values[-1]), "nfev": 500 * dimension, "wall_s": 0.1, "cpu_s": 0.1,
        "objective_s": 0.05, "stop": "budget", "outside_box": 0, "metrics": {},
        "x": {f"x{place}": float(values[0]) for place in range(dimension)},
        "trace": Trace(np.arange(1, IMPROVEMENTS + 1), values),
    }  # fmt: skip


if __name__ == "__main__":
    main(measure)
