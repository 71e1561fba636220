"""Audit an optimizer that nobody trusts, such as a generated one: contract, repetition, and a held-out comparison."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from bench.analysis.cells import cells
from bench.analysis.direction import ALPHA, effects, intervals, mean_of, p_values, stacked
from bench.analysis.pairwise import holm
from bench.check.checker import check_optimizer
from bench.errors import BenchError
from bench.execution.job import Task
from bench.execution.runner import run
from bench.execution.supervisor import check, make_one
from bench.execution.verify import HASH_SEED
from bench.plugins import from_file
from bench.results.results import load_results
from bench.sandbox import bubblewrap
from bench.storage.rows import disagreement
from bench.study import Study

LAYOUT = 1  # of the record; a key that changes its meaning or goes raises it, a new key does not
FUNCTIONS = ("ellipsoid", "rosenbrock", "sharp-ridge", "rastrigin", "ackley", "griewank")
INSTANCES = 15  # of each function, one of which the seed draws
BASELINES = ("random-search", "cma-es")
TRIALS, BUDGET, TIMEOUT = 10, "500 * d", 20.0
CANDIDATE = "candidate"


def audit(
    optimizer: str,
    *,
    problems: Sequence[str] = (),
    baselines: Sequence[str] = BASELINES,
    trials: int = TRIALS,
    budget: int | str = BUDGET,
    timeout: float = TIMEOUT,
    seed: int = 0,
    jobs: int = -1,
    **options: Any,
) -> dict[str, Any]:
    """Check an optimizer, make one of its trials twice, and compare it with baselines; all of it as untrusted code.

    Args:
        optimizer: its name, such as ``"path/file.py:Class"``.
        problems: of the comparison; by default an instance of each of six classical functions of five variables, which
            the seed draws. It is held out where no candidate was chosen by these problems.
        baselines: names of optimizers. One that is shown to be worse than the first of them is refused.
        trials: of each optimizer on each problem, at least 2.
        budget: evaluations of a trial, as in a study.
        timeout: seconds that a trial may take.
        seed: of instances and trials.
        jobs: trials made at a time, -1 for one a core.
        options: parameters of the optimizer.

    Returns:
        A record of JSON values, whose keys docs/reference/audit.md describes.

    Raises:
        BenchError: without bubblewrap, for a file that cannot be read, and for problems, baselines, trials or a budget
            that cannot be.
    """
    bubblewrap.find()
    began = perf_counter()
    files = from_file.contents(filter(from_file.split, [optimizer]))
    record: dict[str, Any] = {
        "audit": LAYOUT, "optimizer": optimizer, "options": options, "seed": seed, "accepted": False, "reasons": [],
        "sha256": next((sha256(file.content).hexdigest() for found in files.values() for file in found.values()), None),
        "check": [], "repetition": None, "comparison": None,
    }  # fmt: skip
    record["reasons"] = _examined(record, list(problems) or drawn(seed), baselines, trials, budget, timeout, jobs)
    return record | {"accepted": not record["reasons"], "seconds": round(perf_counter() - began, 1)}


def drawn(seed: int) -> list[str]:
    """Return the problems of a comparison by default: one instance of each function."""
    draw = random.Random(seed)
    return [f"classical-{function}-d5-i{draw.randint(1, INSTANCES)}" for function in FUNCTIONS]


def _examined(
    record: dict[str, Any], problems: list[str], baselines: Sequence[str], trials: int, budget: int | str,
    timeout: float, jobs: int,
) -> list[dict[str, str]]:  # fmt: skip
    """Fill the record; return the reasons for refusal, after the first stage that has any none of a later one."""
    name, options, seed = record["optimizer"], record["options"], record["seed"]
    others = [{"name": baseline} for baseline in baselines]
    study = Study.from_dict(
        {"name": "audit", "trials": trials, "budget": budget, "seed": seed, "problems": [{"names": problems}],
         "optimizers": [{"name": name, "label": CANDIDATE, **options}, *others]}, "of an audit",
    )  # fmt: skip
    if trials < 2 or not others:
        raise BenchError("an audit compares at least 2 trials with those of at least one baseline")
    try:
        checkup = check_optimizer(name, bias=False, untrusted=True, seed=seed, **options)
    except BenchError as error:
        return [_reason("loading", str(error))]
    record["check"] = [verdict.as_dict() for verdict in checkup]
    if broken := [f"{verdict.check}: {verdict.finding}" for verdict in checkup if not verdict.passed]:
        return [_reason("contract", sentence) for sentence in broken]
    record["repetition"] = repetition = _made_twice(study, timeout)
    if not repetition["same"]:
        return [_reason("repetition", repetition["difference"])]
    with TemporaryDirectory(prefix="bench-audit-") as place:
        output = Path(place) / "audit"
        run(study, output, jobs=jobs, timeout=timeout, untrusted=True, verify=False, progress=False)
        frame = load_results(output)
    record["comparison"] = comparison = _compared(frame, problems, baselines) | {"trials": trials, "budget": budget}
    mine = frame[frame["optimizer"] == CANDIDATE]
    reasons = []
    if len(lost := mine[mine["status"] != "ok"]):
        reasons.append(_reason("trials", f"{len(lost)} of {len(mine)} trials did not finish: {lost['error'].iloc[0]}"))
    first = comparison["baselines"][0]
    if first["outcome"] == "worse":
        share = f"{first['a12']:.0%} of the pairs of trials, p = {first['p_holm']:.2g}"
        reasons.append(_reason("worse", f"it is worse than {first['name']}: it wins {share}"))
    return reasons


def _reason(code: str, text: str) -> dict[str, str]:
    return {"code": code, "text": text.strip().partition("\n")[0]}


def _made_twice(study: Study, timeout: float) -> dict[str, Any]:
    """Return how one trial of the candidate, made twice in processes with other hashes of texts, differs."""
    alone = replace(study, problems=study.problems[:1], optimizers=study.optimizers[:1])
    task = replace(check(Task.of(alone, untrusted=True)).task, timeout=timeout)
    trial = next(iter(alone.plan()))
    rows = [make_one(replace(task, hash_seed=hash_seed), trial) for hash_seed in (0, HASH_SEED)]
    return {"problem": trial.problem, "trial": trial.number} | _difference(*rows)


def _difference(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    if lost := next((row["error"] for row in (one, other) if row["status"] != "ok"), ""):
        return {"same": False, "difference": f"a trial did not finish: {lost}"}
    name = disagreement(one, other)
    return {"same": not name, "difference": f"{name} differs where a trial is made again" if name else ""}


def _compared(frame: Any, problems: list[str], baselines: Sequence[str]) -> dict[str, Any]:
    """Return the chance that a trial of the candidate ends lower than one of each baseline, failed ones the highest.

    The test is of the mean over these problems (:mod:`bench.analysis.direction`), adjusted over the baselines (Holm).
    """
    scores = cells(frame, merge=True)
    compared: list[dict[str, Any]] = []
    for baseline in baselines:
        pairs = [(scores[problem, CANDIDATE], scores[problem, baseline]) for problem in problems]
        estimates = [effects(one[np.newaxis], other[np.newaxis]) for one, other in pairs]
        mean = mean_of(stacked(estimates))
        (low,), (high,) = intervals(mean)
        each = [
            {"problem": problem, "a12": float(found.a12[0]), "median": _median(one), "baseline_median": _median(other)}
            for problem, found, (one, other) in zip(problems, estimates, pairs, strict=True)
        ]
        p = float(p_values(mean)[0])
        about = {"name": baseline, "a12": float(mean.a12[0]), "low": float(low), "high": float(high), "p": p}
        compared.append(about | {"problems": each})
    for entry, p_holm in zip(compared, holm(np.array([entry["p"] for entry in compared])), strict=True):
        shown = "better" if entry["a12"] > 0.5 else "worse"
        entry |= {"p_holm": float(p_holm), "outcome": shown if p_holm <= ALPHA else "undecided"}
    return {"problems": problems, "baselines": compared}


def _median(scores: Any) -> float | None:
    """Return the median of scores; None, which JSON can hold, where half of the trials have no finite one."""
    median = float(np.median(scores))
    return median if np.isfinite(median) else None
