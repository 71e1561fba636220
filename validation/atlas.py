"""Make results/atlas again: the implementations that libraries have of one method, compared with each other.

    python validation/atlas.py [--method NAME …] [--trials 15] [--budget 900] [--output results/runs/atlas]

It needs the extras mealpy, minion, nevergrad, optuna and pymoo. ``results/atlas/methods.toml`` says which optimizers
implement which method. Two implementations are *different* where their trials differ in at least one of ``MEASURES`` on
at least one of ``PROBLEMS`` by the exact Kolmogorov-Smirnov test, adjusted by Holm's method over all tests, so at most
5% of such atlases call any two copies of one algorithm different. Of a letter's group no two differ.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from bench.analysis import holm
from bench.analysis.finished_trials import CLAMPED
from bench.analysis.kolmogorov_smirnov import ks_tests
from bench.check.bias import FLOOR, LIMIT, mean_log_error
from bench.check.conformance.single import single_run
from bench.check.idle import alternatives
from bench.check.problems import FUNCTIONS, classic
from bench.check.runs import on_bound
from bench.contract.seeds import trial_seed
from bench.helpers.markdown import table
from bench.plugins.loading import default_label, load_optimizer, package
from bench.report.wording import cell_text

TABLE = Path(__file__).resolve().parents[1] / "results" / "atlas" / "methods.toml"
DIMENSION = 5
LEAST = 1e-12  # of logarithms
PROBLEMS = tuple(f"{name} {place}" for name in FUNCTIONS for place in ("centred", "moved"))
PROBES = ("sphere moved", "Rastrigin moved")  # the functions on which parameters are changed
MEASURES = ("start", "next", "course", "final")
"""Of a trial: log10 of the median value of its first generation and of the two after it; the mean over eighths of the
budget of log10 of the best value so far; and the final best value."""


@dataclass(frozen=True)
class Surveyed:
    """An implementation and its runs: (trials, measures) by problem, and parameters without effect by name."""

    method: str
    label: str
    name: str
    options: dict[str, Any] = field(default_factory=dict)
    differs: str = ""
    source: str = ""
    code: str = ""
    measures: dict[str, np.ndarray] = field(default_factory=dict)
    clamped: float = np.nan
    evaluations: float = np.nan
    repeatable: bool = True
    dead: dict[str, str] = field(default_factory=dict)
    microseconds: float = np.nan

    @property
    def key(self) -> str:
        """Its name in the whole atlas."""
        return f"{self.method} {self.label}"

    @property
    def centre_bias(self) -> float:
        """How many times as high errors are where the optimum is moved from the centre: a geometric mean."""
        logs = {problem: mean_log_error(values[:, -1]) for problem, values in self.measures.items()}
        differences = [logs[f"{name} moved"] - logs[f"{name} centred"] for name in FUNCTIONS if logs]
        return float(np.exp(np.mean(differences))) if differences else np.nan

    @property
    def findings(self) -> list[str]:
        """What its runs show of it alone, in words."""
        sentences = []
        if self.centre_bias > LIMIT:
            sentences.append(f"biased to the centre (errors are {self.centre_bias:.3g} times as high away from it)")
        if self.clamped > CLAMPED:
            sentences.append(f"biased to the bounds ({self.clamped:.0%} of the best points' coordinates lie on them)")
        if dead := [f"{name} (tried {tried})" for name, tried in self.dead.items()]:
            sentences.append(f"without effect: {', '.join(dead)}")
        return sentences + ["a seed does not repeat its runs"] * (not self.repeatable)


def main() -> None:
    parser = argparse.ArgumentParser(description="Make results/atlas again.")
    parser.add_argument("--method", action="append", help="a method of the table; repeatable; all by default")
    parser.add_argument("--trials", type=int, default=15)
    parser.add_argument("--budget", type=int, default=900)
    parser.add_argument("--output", type=Path, default=Path("results/runs/atlas"))
    asked, content = parser.parse_args(), tomllib.loads(TABLE.read_text(encoding="utf-8"))
    methods = {name: each for name, each in content["methods"].items() if not asked.method or name in asked.method}
    surveyed = survey(methods, content["technical"], asked.trials, asked.budget)
    write(asked.output, methods, surveyed, tested(surveyed), f"{asked.trials} trials of {asked.budget:,} evaluations")


# The runs


def survey(methods: Mapping[str, Any], technical: Sequence[str], trials: int, budget: int) -> list[Surveyed]:
    """Run all implementations; a trial's seed depends on its implementation, problem and number alone."""
    entries = [
        Surveyed(method, each.pop("label", default_label(each["name"])), **each)
        for method, table in methods.items()
        for each in table["implementations"]
    ]
    generations = [methods[seen.method].get("generation", 30) for seen in entries]
    calls = (delayed(ran)(*call, technical, trials, budget) for call in zip(entries, generations, strict=True))
    return list(Parallel(n_jobs=-1, verbose=10, batch_size=1)(calls))


def ran(seen: Surveyed, generation: int, technical: Sequence[str], trials: int, budget: int) -> Surveyed:
    """Make the runs of an implementation and return it with what they show."""
    tasks = [
        (problem, budget, trial_seed(0, problem, seen.key, trial), generation)
        for problem in PROBLEMS
        for trial in range(trials)
    ]
    firsts = [tasks[PROBLEMS.index(problem) * trials] for problem in PROBES]
    optimizer = load_optimizer(seen.name, **seen.options)
    *records, again = [run(seen.name, seen.options, task) for task in [*tasks, firsts[0]]]
    numbers = {
        name: np.array([record[name] for record in records], dtype=float).reshape(len(PROBLEMS), trials, -1)
        for name in ("measures", "clamped", "evaluations", "cpu_s")
    }
    repeatable = again["points"] == records[tasks.index(firsts[0])]["points"]
    probes = {name: values for name, values in alternatives(optimizer).items() if repeatable and name not in technical}
    tried = {name: idle(seen, name, values, firsts) for name, values in probes.items()}
    return replace(
        seen,
        code=optimizer.code,
        measures=dict(zip(PROBLEMS, numbers["measures"], strict=True)),
        clamped=float(numbers["clamped"].mean()),
        evaluations=float(np.median(numbers["evaluations"])),
        microseconds=float(np.median(1e6 * numbers["cpu_s"] / numbers["evaluations"])),
        repeatable=repeatable,
        dead={name: values for name, values in tried.items() if values},
    )


def run(name: str, options: Mapping[str, Any], task: Sequence[Any]) -> dict[str, Any]:
    """Make one run and return its measures; the task is its problem, budget, seed and generation."""
    label, budget, seed, generation = task
    function, place = label.rsplit(" ", 1)
    problem = classic(function, DIMENSION, moved=place == "moved")
    result = single_run(problem, load_optimizer(name, **options), budget, seed)
    points = problem.points[:budget]
    values = np.asarray(problem.noiseless(points), dtype=float)
    generation = min(generation, len(values))
    following = values[generation : 3 * generation]
    medians = [np.median(values[:generation]), np.median(following if len(following) else values[:generation])]
    lowest = np.maximum(np.minimum.accumulate(np.where(np.isfinite(values), values, np.inf)), LEAST)
    ends = np.minimum(np.rint(np.linspace(0, budget, 9)).astype(int)[1:], len(values))
    course = np.minimum(np.log10(lowest[ends - 1]), -2 * np.log10(LEAST)).mean()
    return {
        "measures": np.array([*(float(np.log10(max(each, LEAST))) for each in medians), course, float(result.fun)]),
        "clamped": float(on_bound(problem.share(result.x)).mean()),
        "evaluations": len(points),
        "points": hashlib.sha256(points.tobytes()).hexdigest(),
        "cpu_s": result.cost.cpu_s,
    }


def idle(seen: Surveyed, parameter: str, values: Sequence[Any], tasks: Sequence[tuple[Any, ...]]) -> str:
    """Return the values tried of a parameter, "" where one changed a point; a refused value shows nothing."""
    usual = [run(seen.name, seen.options, task)["points"] for task in tasks]
    tried = []
    for value in values:
        try:
            changed = seen.options | {parameter: value}
            if [run(seen.name, changed, task)["points"] for task in tasks] != usual:
                return ""
        except (Exception, SystemExit):  # a library may raise anything
            continue
        tried.append(repr(value))
    return ", ".join(tried)


# The comparison


def tested(surveyed: Sequence[Surveyed]) -> pd.DataFrame:
    """Return a row for each test of each pair of implementations of one method, adjusted over all."""
    rows = []
    for one, rival in combinations(surveyed, 2):
        for problem, these in one.measures.items() if one.method == rival.method else ():
            made = ks_tests(these.T, rival.measures[problem].T)
            rows += [
                (one.method, one.label, rival.label, problem, measure, float(distance), float(p))
                for measure, distance, p in zip(MEASURES, made["ks_distance"], made["ks_p"], strict=True)
            ]
    frame = pd.DataFrame(rows, columns=["method", "first", "second", "problem", "measure", "ks_distance", "p"])
    return frame.assign(p_holm=holm(frame["p"].to_numpy(dtype=float)))


def paired(tests: pd.DataFrame, seen_by_key: Mapping[str, Surveyed]) -> pd.DataFrame:
    """Return a row a pair: whether it is different, on how many functions by measure, and the largest difference."""
    rows = []
    for (method, first, second), of_pair in tests.groupby(["method", "first", "second"], sort=False):
        significant = of_pair[of_pair["p_holm"] <= 0.05]
        one, rival = seen_by_key[f"{method} {first}"], seen_by_key[f"{method} {second}"]
        ours, theirs = (
            {problem: np.log10(max(np.median(values[:, -1]), FLOOR)) for problem, values in seen.measures.items()}
            for seen in (one, rival)
        )
        orders = {
            problem: float(theirs[problem] - ours[problem])
            for problem in significant.loc[significant["measure"] == "final", "problem"]
        }
        where = max(orders, key=lambda problem: abs(orders[problem]), default="")
        counts = {name: int((significant["measure"] == name).sum()) for name in MEASURES}
        rows.append(
            {"method": method, "first": first, "second": second, "different": len(significant) > 0}
            | counts | {"orders": orders.get(where, 0.0), "problem": where}
        )  # fmt: skip
    return pd.DataFrame(rows, columns=["method", "first", "second", "different", *MEASURES, "orders", "problem"])


def grouped(surveyed: Sequence[Surveyed], pairs: pd.DataFrame) -> dict[str, str]:
    """Return for each implementation the first letter that none before it has from which it differs."""
    different = pairs[pairs["different"].astype(bool)]
    groups: dict[str, str] = {}
    for seen in surveyed:
        before = different[(different["method"] == seen.method) & (different["second"] == seen.label)]["first"]
        taken = {groups[f"{seen.method} {label}"] for label in before}
        groups[seen.key] = next(letter for letter in "ABCDEFGHIJKLM" if letter not in taken)
    return groups


# The pages


def write(output: Path, methods: dict[str, Any], surveyed: list[Surveyed], tests: pd.DataFrame, size: str) -> None:
    """Write the tables and the pages into a folder."""
    output.mkdir(parents=True, exist_ok=True)
    pairs = paired(tests, {seen.key: seen for seen in surveyed})
    groups = grouped(surveyed, pairs)
    rows = [
        {
            "method": seen.method, "label": seen.label, "optimizer": seen.name, "options": json.dumps(seen.options),
            "code": seen.code, "group": groups[seen.key], "evaluations": seen.evaluations,
            "centre_bias": seen.centre_bias, "on_bounds": seen.clamped, "repeatable": seen.repeatable,
            "without_effect": json.dumps(seen.dead),
        } for seen in surveyed
    ]  # fmt: skip
    medians = [
        (seen.method, seen.label, problem, *np.median(values, axis=0).tolist())
        for seen in surveyed for problem, values in seen.measures.items()
    ]  # fmt: skip
    times = [(seen.method, seen.label, seen.microseconds) for seen in surveyed]
    frames = {"implementations": pd.DataFrame(rows), "pairs": pairs, "tests": tests}
    frames["medians"] = pd.DataFrame(medians, columns=["method", "label", "problem", *MEASURES])
    frames["times"] = pd.DataFrame(times, columns=["method", "label", "microseconds_an_evaluation"])
    for name, frame in frames.items():
        frame.to_csv(output / f"{name}.csv", index=False, lineterminator="\n", encoding="utf-8")
    size = f"{size} on each of {len(PROBLEMS)} functions, d = {DIMENSION}"
    pages = {"index": index_page(methods, surveyed, tests, pairs, groups, size)}
    for name, method in methods.items():
        of_method = [seen for seen in surveyed if seen.method == name]
        pages[name] = method_page(method, of_method, pairs[pairs["method"] == name], groups, size)
    for name, parts in pages.items():
        (output / f"{name}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8", newline="\n")


def index_page(
    methods: Mapping[str, Any], surveyed: Sequence[Surveyed], tests: pd.DataFrame, pairs: pd.DataFrame,
    groups: Mapping[str, str], size: str,
) -> list[str]:  # fmt: skip
    """Return the paragraphs of the first page: methods by libraries, and what else was found."""
    of_library = {seen.key: package(seen.name).partition(" ")[0] for seen in surveyed}
    libraries = list(dict.fromkeys(of_library.values()))
    rows = []
    for name, method in methods.items():
        cells = {library: [] for library in libraries}
        for seen in (each for each in surveyed if each.method == name):
            cells[of_library[seen.key]].append(f"`{seen.label.rpartition(':')[2]}` **{groups[seen.key]}**")
        rows.append([f"[{escaped(method['title'])}]({name}.md)", *map(", ".join, cells.values())])
    noted = [[escaped(seen.method), f"`{seen.label}`", escaped(each)] for seen in surveyed for each in seen.findings]
    several = pairs.groupby("method")["different"].sum()
    rule = (
        f"p is adjusted by Holm's method over all {len(tests):,} exact Kolmogorov-Smirnov tests (pairs, functions and "
        "measures), at 5%. Implementations of one letter were not found different from each other. "
        f"{pairs['different'].sum()} of {len(pairs)} pairs of implementations of one method are different. In "
        f"{(several == 0).sum()} of {len(several)} methods with several implementations, no pair is."
    )
    return [
        "# An atlas of implementations",
        f"{len(surveyed)} implementations of {len(methods)} methods: {size}; seed 0.",
        rule,
        table(["method", *map(escaped, libraries)], rows),
        "## Biases, parameters without effect, failures",
        table(["method", "implementation", "finding"], noted),
        "## Versions",
        "\n".join(f"- {escaped(each)}" for each in sorted({seen.code for seen in surveyed})),
    ]


def method_page(
    method: Mapping[str, Any], of_method: Sequence[Surveyed], pairs: pd.DataFrame, groups: Mapping[str, str], size: str
) -> list[str]:
    """Return the paragraphs of the page of a method: its implementations, their differences, median final bests."""
    implementations = [
        [f"`{seen.label}`", groups[seen.key], escaped(seen.code), cell_text(round(seen.evaluations)),
         escaped("; ".join(seen.findings))] for seen in of_method
    ]  # fmt: skip
    medians = [[problem, *(cell_text(float(np.median(seen.measures[problem][:, -1]))) for seen in of_method)]
               for problem in PROBLEMS]  # fmt: skip
    parts = [
        f"# {escaped(method['title'])}",
        escaped(f"{size}. {method.get('conditions', '')}".strip()),
        table(["implementation", "letter", "code", "evaluations", "finding"], implementations),
    ]
    if len(pairs):
        heads = ["pair", "verdict", *MEASURES, "largest difference"]
        columns = f"The columns count the functions, of {len(PROBLEMS)}, on which a pair differs in the measure."
        parts += ["## Which of them differ", columns, table(heads, map(pair_row, pairs.to_dict("records")))]
    parts += ["## Options, and what is documented", "\n".join(map(documented, of_method))]
    return [*parts, "## Median final bests", table(["function", *(f"`{seen.label}`" for seen in of_method)], medians)]


def escaped(text: str) -> str:
    return "".join(f"\\{letter}" if letter in "\\`*_[]<>#$" else letter for letter in text)


def pair_row(row: Mapping[Any, Any]) -> list[str]:
    lower = row["first" if row["orders"] > 0 else "second"]
    largest = f"{abs(row['orders']):.1f} orders of magnitude on {row['problem']}, `{lower}` lower"
    verdict = "**different**" if row["different"] else "not found different"
    counts = (str(row[measure]) for measure in MEASURES)
    return [f"`{row['first']}`, `{row['second']}`", verdict, *counts, largest if row["problem"] else "–"]


def documented(seen: Surveyed) -> str:
    options = ", ".join(f"{name} = {value!r}" for name, value in seen.options.items()) or "default options"
    name = "" if seen.label == seen.name else f"`{seen.name}`, "
    source = f" ({escaped(seen.source)})" if seen.source else ""
    return f"- `{seen.label}`: {name}{escaped(options)}. {escaped(seen.differs)}{source}".rstrip()


if __name__ == "__main__":
    main()
