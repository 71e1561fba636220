"""What the report of a whole suite takes: 24 functions, 3 dimensions and 15 instances of bbob, 10 and 40 optimizers.

No search is run. Each trial has made-up improvements, like those of a run on bbob: between 50 and 300, spread evenly
over the logarithm of the evaluations, until the function is solved, the search is stuck or the budget ends. The
problems are the real ones, so that optima and groups are known. Each report is written in a process of its own, whose
memory is measured; on one core and on all of them its files must be the same.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from _rows import Cost, Rows, apart, main, short, times
from joblib import cpu_count

from bench import Study, Trace
from bench.contract.problem import Problem
from bench.storage.folder import Folder
from bench.trial.columns import Row, packed
from bench.trial.trial import Trial

STUDY = {
    "name": "suite",
    "title": "A whole suite, with made-up results",
    "seed": 1,
    "trials": 1,
    "budget": "1e4 * d",
}
SUITE = {"suite": "bbob", "functions": "1-24", "dimensions": [2, 5, 10], "instances": "1-15"}
QUICK = {"suite": "bbob", "functions": "1-3", "dimensions": [2], "instances": "1-3"}
SOLVED = -8.0  # the logarithm of the precision at which a search ends

Files = dict[str, bytes]


def measure(quick: bool) -> Rows:
    sizes = (2, 4) if quick else (10, 40)
    with tempfile.TemporaryDirectory() as place:
        studies = [made(Path(place) / str(number), QUICK if quick else SUITE, number) for number in sizes]
        few, files = written(studies[0], 1)
        every, again = written(studies[0], -1)
        many, _ = written(studies[1], 1)
    if files != again:
        other = sorted(name for name in files if files[name] != again.get(name))
        sys.exit(f"the report has other files with {cpu_count()} jobs: {', '.join(other)}")
    page = len(files["report.html"]) / 1e6
    return [
        (
            f"report of a suite with made-up results of {sizes[0]} optimizers, on one core",
            f"{short(few.wall_s)} s, at most {few.peak_mb:.0f} MB, a page of {page:.1f} MB",
        ),
        (f"the same on {cpu_count()} cores", f"{short(every.wall_s)} s, {times(few.wall_s / every.wall_s)} as fast"),
        (
            f"the same of {sizes[1]} optimizers, on one core",
            f"{short(many.wall_s)} s, {times(many.wall_s / few.wall_s)} as long; at most {many.peak_mb:.0f} MB",
        ),
    ]


def written(folder: Path, jobs: int) -> tuple[Cost, Files]:
    """Return what a report takes, and its files."""
    with tempfile.TemporaryDirectory() as place:
        code = "bench.write_report(sys.argv[1], output=sys.argv[2], n_jobs=int(sys.argv[3]))"
        took = apart("import bench", code, str(folder), place, str(jobs))
        files = {str(path.relative_to(place)): path.read_bytes() for path in Path(place).rglob("*") if path.is_file()}
    return took, files


def made(folder: Path, suite: dict[str, object], optimizers: int) -> Path:
    """Return a folder with a study of a suite and made-up results; the same every time."""
    entries = [{"name": "random-search", "label": f"optimizer-{number}"} for number in range(1, optimizers + 1)]
    study = Study.from_dict(STUDY | {"problems": [suite], "optimizers": entries})
    folder.mkdir(parents=True)
    place = Folder(folder)
    place.claim(study)
    problems = {entry.label: study.problem(entry.label) for entry in study.problems}
    skills = {entry.label: number / len(study.optimizers) for number, entry in enumerate(study.optimizers)}
    with place.store.writer() as writer, writer.transaction():
        for trial in study.plan():
            problem = problems[trial.problem]
            budget = study.budget.evaluations(len(problem.lower))
            writer.put(packed(row(trial, problem, skills[trial.optimizer], budget)) | trial.columns)
    return folder


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
    main(measure)
