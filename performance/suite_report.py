"""What the report of a whole suite takes: 24 functions, 3 dimensions and 15 instances of bbob, 10 optimizers.

    python performance/suite_report.py [--keep FOLDER] [--rounds 1] [--optimizers 280]

No search is run. Each of the 10,800 trials has made-up improvements, like those of a run on bbob: between 50 and 300,
spread evenly over the logarithm of the evaluations, until the function is solved, the search is stuck or the budget
ends. The problems are the real ones, so that optima and groups are known.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from bench import Study, Trace
from bench.problem import Problem
from bench.storage.folder import Folder
from bench.storage.rows import stored
from bench.trial import Row, Trial

STUDY = {
    "name": "suite",
    "title": "A whole suite, with made-up results",
    "seed": 1,
    "trials": 1,
    "budget": "1e4 * d",
    "problems": [{"suite": "bbob", "functions": "1-24", "dimensions": [2, 5, 10], "instances": "1-15"}],
}
SOLVED = -8.0  # the logarithm of the precision at which a search ends


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", type=Path, help="make the store in this folder, or take the one that is there")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--optimizers", type=int, default=10, help="10 by default; 280 are what COCO's archive holds")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = chosen.keep or Path(place) / "suite"
        if not (folder / "trials.sqlite").exists():
            labels = [f"optimizer-{place}" for place in range(1, chosen.optimizers + 1)]
            optimizers = [{"name": "random-search", "label": label} for label in labels]
            make(folder, Study.from_dict(STUDY | {"optimizers": optimizers}))
        # in a process of its own, whose memory is measured
        command = [sys.executable, str(Path(__file__).with_name("report.py")), str(folder), str(chosen.rounds)]
        sys.exit(subprocess.run(command, check=False).returncode)


def make(folder: Path, study: Study) -> None:
    """Write a study of suites into a folder, with made-up results; the same every time."""
    folder.mkdir(parents=True, exist_ok=True)
    place = Folder(folder)
    place.claim(study)
    problems = {entry.label: study.problem(entry.label) for entry in study.problems}
    skills = {entry.label: number / len(study.optimizers) for number, entry in enumerate(study.optimizers)}
    with place.store.writer() as writer, writer.transaction():
        for trial in study.plan():
            problem = problems[trial.problem]
            budget = study.evaluations(len(problem.lower))
            writer.put(stored(trial, row(trial, problem, skills[trial.optimizer], budget)))


def row(trial: Trial, problem: Problem, skill: float, budget: int) -> Row:
    """Return the row of a trial of an optimizer with a skill from 0, the best, to 1."""
    rng = np.random.default_rng(trial.seed)
    d, hardness = len(problem.lower), int(str(problem.features["function"])[1:]) / 24
    needed = 10 ** (2 + 2 * hardness + 1.2 * skill + 0.15 * rng.standard_normal()) * d ** (1.1 + 0.4 * skill)
    floor = rng.uniform(-3, 1) if rng.random() < hardness * (0.3 + 0.6 * skill) else SOLVED - rng.uniform(0, 1)
    evaluations = np.unique(np.append(1, np.geomspace(1, budget, rng.integers(50, 300)) * rng.uniform(0.95, 1)).round())
    start = rng.uniform(1.5, 4)
    passed = np.log(evaluations) / np.log(needed)
    levels = start - (start - SOLVED) * passed**1.5 + 0.2 * rng.standard_normal(len(passed))
    values = problem.optimum + 10 ** np.maximum(np.minimum.accumulate(levels), floor)
    improved = np.append(True, values[1:] < values[:-1])
    trace = Trace(evaluations[improved].astype(np.int64), values[improved])
    solved = floor < SOLVED and levels.min() <= SOLVED
    spent = int(trace.evaluations[-1] * 1.05) if solved else budget
    wall = spent * (2e-6 + 2e-5 * skill) * rng.uniform(0.9, 1.1)
    point = rng.uniform(problem.lower, problem.upper)
    return {
        "status": "ok", "fun": trace.values[-1], "nfev": min(spent, budget), "wall_s": wall, "cpu_s": wall,
        "objective_s": 1.2e-6 * spent, "stop": "ftol" if solved and spent < budget else "budget", "outside_box": 0,
        "x": dict(zip(problem.variables, point.tolist(), strict=True)), "metrics": {}, "trace": trace,
    }  # fmt: skip


if __name__ == "__main__":
    main()
