"""Make results/suites again: functions of CEC and BBOB, beside those of other libraries at the same 64 points.

    python validation/suites.py [SUITE …] [--output results/runs/suites]

A library that is not installed is missing in the tables; ``results/suites/README.md`` has the versions. A function is
equal to the last bit or to rounding, equal up to a transformation, or different. The whole takes half a minute.
"""

from __future__ import annotations

import argparse
import re
from collections import namedtuple
from functools import partial
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from scipy.stats import spearmanr

from bench import FunctionProblem, Problem, load_problem
from bench.contract.families import Member
from bench.helpers.markdown import table
from bench.helpers.text import joined
from bench.plugins import registry

MARKUP = str.maketrans({letter: f"\\{letter}" for letter in "\\`*_[]<>#$"})  # in Markdown
POINTS, NEAR, INSTANCES = 64, 0.02, 3  # NEAR: of the box, how far half of the points lie from the optimum
ROUNDING, SMALL = 1e-9, 1e-6  # relative to the larger of two values; of the largest value
PLACES = {"rosenbrock": 1.0, "levy": 1.0, "schwefel-2-26": 420.968746, "styblinski-tang": -2.903534}
WORDS = {"bits": "equal", "rounding": "equal to rounding", "transformed": "transformed", "different": "different",
         "missing": "–"}  # fmt: skip
STUDIES: dict[str, tuple[list[str], dict[str, Any], int]] = {  # others, options of the suite's problems, dimension
    "cec2014": (["pygmo2014", "opfunu2014"], {}, 10),
    **{f"cec{year}": ([f"opfunu{year}"], {}, 10) for year in (2017, 2019, 2020)},
    "cec2022": (["opfunu2022", "ioh2022", "evox2022"], {}, 10),
    "bbob": (["ioh_bbob", "pymoo_bbob", "bbobtorch"], {}, 10),
    "bbob-boxed": (["sbox-cost", "bbob"], {}, 2),
    "classical": (["niapy", "pymoo"], {"rotate": False}, 10),
}


def their_problem(source: str, function: Any, d: int, instance: int) -> Problem:
    """Return a library's function, with its optimum where the library or the literature has it."""
    name, year = re.fullmatch(r"([a-z_]+)(\d*)", source).groups()  # type: ignore[union-attr]
    place, by_point = [PLACES.get(function, 0.0)] * d, partial(FunctionProblem, vectorized=False)
    if name == "opfunu":
        made = getattr(import_module("opfunu").cec_based, f"F{function}{year}")(ndim=d)
        return by_point(made.evaluate, made.lb, made.ub, optimum=made.f_global, optimum_point=made.x_global)
    if name.startswith("ioh"):
        ioh = import_module("ioh")
        number = (1000 + function, 1) if year else (function, instance)
        made = ioh.get_problem(*number, d, ioh.ProblemClass.CEC2022 if year else ioh.ProblemClass.BBOB)
        return by_point(made, made.bounds.lb, made.bounds.ub, optimum=made.optimum.y, optimum_point=made.optimum.x)
    if name == "pygmo":
        made = (pygmo := import_module("pygmo")).problem(pygmo.cec2014(function, d))
        return by_point(lambda x: made.fitness(x)[0], *made.get_bounds())
    if name == "niapy":
        title = {"schwefel-2-26": "Schwefel"}.get(function, function.replace("-", " ").title())
        made = getattr(import_module("niapy.problems"), title.replace(" ", ""))(dimension=d)
        return by_point(made.evaluate, made.lower, made.upper, optimum_point=place)
    if name in ("pymoo", "pymoo_bbob"):
        known = {} if name == "pymoo_bbob" else {"optimum_point": [0.5] * d if function == "sphere" else place}
        title = function.partition("-2-26")[0] if known else f"bbob-f{function:02d}-{instance}"
        made = import_module("pymoo.problems").get_problem(title, n_var=d)
        return FunctionProblem(lambda x: made.evaluate(x).ravel(), made.xl, made.xu, vectorized=True, **known)
    torch = import_module("torch")
    if name == "evox":
        torch.set_default_dtype(torch.float64)
        made = import_module("evox.problems.numerical.cec2022").CEC2022(function, d)
        return FunctionProblem(lambda x: made.evaluate(torch.tensor(x)).numpy(), [-100] * d, [100] * d, vectorized=True)
    made = getattr(import_module("bbobtorch"), f"create_f{function:02d}")(d, seed=instance)
    known = {"optimum": float(made.f_opt), "optimum_point": made.x_opt.double().numpy()}
    box = made.x_min.double().numpy(), made.x_max.double().numpy()
    return FunctionProblem(lambda x: made(torch.tensor(x).float()).double().numpy(), *box, vectorized=True, **known)


Sample = namedtuple("Sample", "box optimum best raw shares about")
"""A function's values at the common points, at the same shares of its own box, and about its own optimum."""

Verdict = namedtuple("Verdict", "other function dimension instance verdict agree detail")
"""The verdict on a function of another implementation; ``agree`` is the share of points that agree to rounding."""


def sampled(source: str, member: Member, options: dict[str, Any], frame: Sample | None) -> Sample | str:
    """Compute a function at points of the first implementation's ``frame``; return why where it cannot be."""
    function, d, instance = member
    try:
        if registry.entry("problems", source):
            name = f"{source}-{function}-d{d}" + (f"-i{instance}" if instance else "")
            problem = load_problem(name, **options)
        else:
            number = int(function[1:]) if re.fullmatch(r"f\d+", function) else function
            problem = their_problem(source, number, d, max(1, instance))
        box, nowhere = np.array([problem.lower, problem.upper]), np.full(d, np.nan)
        best = nowhere if problem.optimum_point is None else np.asarray(problem.optimum_point, dtype=float)
        base, origin = (box, best) if frame is None else (frame.box, frame.best)
        rng, width = np.random.default_rng(0), base[1] - base[0]
        points = base[0] + rng.random((POINTS, d)) * width
        offsets = (rng.random(points.shape) - 0.5) * 2 * NEAR * width
        if np.isfinite(origin).all():
            points[POINTS // 2 :] = np.clip(origin + offsets[POINTS // 2 :], *base)
            points[-1], offsets[-1] = origin, 0.0
        at = points, box[0] + (points - base[0]) / width * (box[1] - box[0]), best + offsets
        views = [problem.noiseless(x) if np.isfinite(x).all() else np.full(POINTS, np.nan) for x in at]
        return Sample(box, np.nan if problem.optimum is None else problem.optimum, best, *views)
    except Exception as error:  # a library may raise anything
        return f"{type(error).__name__}: {error}".partition("\n")[0]


def judged(suite: str) -> list[Verdict]:
    """Return the verdict on every function of each other implementation of a suite, in order."""
    others, options, dimension = STUDIES[suite]
    grid: Any = registry.grid(suite)
    sizes = {name: dimension if dimension in each else min(each) for name, each in grid.functions.items()}
    numbers = range(1, min(grid.instances, INSTANCES) + 1) if grid.instances else (0,)
    members = [Member(function, size, number) for function, size in sizes.items() for number in numbers]
    parallel = Parallel(n_jobs=-1)
    first = parallel(delayed(sampled)(suite, member, options, None) for member in members)
    calls = [(other, member, {}, own) for other in others for member, own in zip(members, first, strict=True)]
    made = parallel(delayed(sampled)(*call) for call in calls)
    samples = {(call[0], call[1]): sample for call, sample in zip(calls, made, strict=True)}
    return [verdict(other, member, own, samples) for other, member, _, own in calls]


def verdict(other: str, member: Member, own: Any, samples: dict[Any, Any]) -> Verdict:
    """Return the verdict on one function; one with the values of another number is no other function."""
    if isinstance(sample := samples[other, member], str):
        return Verdict(other, *member, "missing", 0.0, sample)
    kind, detail = compared(own, sample)
    for (source, one), theirs in samples.items() if kind == "different" else ():
        alike = source == other and one[1:] == member[1:] and one != member and not isinstance(theirs, str)
        half = slice(POINTS // 2)  # functions of one box are computed at the same points there
        if alike and np.array_equal(own.box, theirs.box) and close(own.raw[half], theirs.raw[half]).all():
            kind, detail = "transformed", f"it has the values of its {one.function}"
            break
    return Verdict(other, *member, kind, float(close(own.raw, sample.raw).mean()), detail)


def compared(first: Sample, second: Sample) -> tuple[str, str]:
    """Return the verdict on two samples of a function, and the details."""
    if np.array_equal(first.raw, second.raw, equal_nan=True):
        return "bits", ""
    if close(first.raw, second.raw).all():
        return "rounding", f"relative differences of up to {apart(first.raw, second.raw).max():.1e}"
    views = {"": (first.raw, second.raw)}
    if not np.array_equal(first.box, second.box):
        views["at the same shares of another box"] = first.shares, second.shares
    if not np.array_equal(first.best, second.best):
        views["about its own optimum, which lies elsewhere"] = first.about, second.about
    usable = {where: pair for where, pair in views.items() if np.isfinite(pair[0]).any() and len(set(pair[1])) > 1}
    for where, (a, b) in usable.items():
        if where and close(a, b).all():
            return "transformed", f"equal {where}"
    for where, (a, b) in usable.items():
        if words := scaled(a, b):
            return "transformed", f"{words} {where}".rstrip()
    for where, (a, b) in usable.items():
        if np.isfinite(a).all() and all(b[i] < b[j] for i, j in pairwise(a.argsort(kind="stable")) if a[i] < a[j]):
            return "transformed", f"its values have the same order {where}".rstrip()
    return "different", difference(first, second)


def apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return relative differences; values below ``SMALL`` of the largest count as that large: terms that cancel."""
    scale = SMALL * float(np.max(np.abs(a[np.isfinite(a)]), initial=0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.abs(a - b) / np.maximum(np.maximum(np.abs(a), np.abs(b)), max(scale, 1e-300))
    return np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, np.nan_to_num(found, nan=np.inf))


def close(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(apart(a, b) <= ROUNDING)


def scaled(a: np.ndarray, b: np.ndarray) -> str:
    """Return how values ``b`` are a scale and a shift of ``a``, in words; "" where they are not."""
    finite = np.isfinite(a) & np.isfinite(b)
    if finite.sum() < 3 or (np.isfinite(a) != np.isfinite(b)).any() or np.ptp(a[finite]) == 0:
        return ""
    x, y = a[finite], b[finite]
    scale = (y[x.argmax()] - y[x.argmin()]) / (x.max() - x.min())
    shift = y[x.argmin()] - scale * x.min()
    if scale == 0 or not (np.abs(scale * x + shift - y) <= ROUNDING * np.abs(y).max()).all():
        return ""
    moved = "" if abs(shift) <= ROUNDING * np.abs(y).max() else f"{shift:+.10g}"
    times = "" if abs(scale - 1) <= ROUNDING else f"{scale:.10g} times "
    return f"its value is {times}the suite's {moved}".rstrip(" " * bool(times))


def difference(first: Sample, second: Sample) -> str:
    """Return in words how far two samples are apart, and where."""
    found = apart(first.raw, second.raw)
    finite, differing = np.isfinite(first.raw) & np.isfinite(second.raw), found[found > ROUNDING]
    parts = [f"{len(differing)} of {len(found)} values differ"]
    if np.isfinite(median := np.median(differing)):
        parts[0] += f", by {median:.2g} of the value in the median"
    if len(differing) > 2 and finite.sum() > 2 and np.ptp(second.raw[finite]) > 0:
        parts.append(f"rank correlation {spearmanr(first.raw[finite], second.raw[finite]).statistic:.3f}")
    if np.isfinite(first.best).all() and found[-1] > ROUNDING:
        parts.append(f"{second.raw[-1]:.10g} in place of {first.raw[-1]:.10g} at the suite's optimum")
    if np.isfinite([first.optimum, second.optimum]).all() and first.optimum != second.optimum:
        parts.append(f"claims the optimum {second.optimum:.10g}, not {first.optimum:.10g}")
    return "; ".join(parts + ["another box"] * (not np.array_equal(first.box, second.box)))


def page(suite: str, verdicts: list[Verdict]) -> str:
    """Return the page of a suite: a row a function, the worst of its instances, and what differs."""
    rows: dict[tuple[str, str], Verdict] = {}
    for one in verdicts:
        worst = rows.get((one.other, one.function), one)
        rows[one.other, one.function] = max(worst, one, key=lambda each: [*WORDS].index(each.verdict))
    others, functions = (list(dict.fromkeys(names)) for names in zip(*rows, strict=True))
    sizes = joined([str(size) for size in sorted({one.dimension for one in verdicts})])
    cells = [[function, *(WORDS[rows[other, function].verdict] for other in others)] for function in functions]
    details = [
        [f"`{one.other}`", one.function, WORDS[one.verdict], one.detail.translate(MARKUP)]
        for one in rows.values()
        if one.verdict not in ("bits", "rounding")
    ]
    parts = [
        f"# {suite} in other implementations",
        f"The values of each function in {sizes} dimensions, beside those of `{suite}` at the same points.",
        table(["function", *(other.translate(MARKUP) for other in others)], cells),
        "## What differs",
        table(["implementation", "function", "verdict", "detail"], details),
    ]
    return "\n\n".join(parts) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description="Make results/suites again.")
    parser.add_argument("suite", nargs="*", default=[*STUDIES])
    parser.add_argument("--output", type=Path, default=Path("results/runs/suites"))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    for suite in asked.suite:
        verdicts = judged(suite)
        frame = pd.DataFrame(verdicts)
        frame.to_csv(asked.output / f"{suite}.csv", index=False, lineterminator="\n")
        (asked.output / f"{suite}.md").write_text(page(suite, verdicts), encoding="utf-8", newline="\n")
        print(suite, frame.groupby("other", sort=False)["verdict"].value_counts().to_dict())


if __name__ == "__main__":
    main()
