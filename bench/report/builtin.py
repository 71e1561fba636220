"""The sections every study's report has."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pandas as pd

from bench.analysis import ALPHA, CONTENTION, HIDDEN_THREADS
from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.plots import convergence_figure, distribution_figure, timing_figure
from bench.report.verdict import completeness, verdict
from bench.report.words import count, listing, seconds


def opening_sections(findings: Findings) -> list[Section]:
    """Return what comes before the plug-ins' sections: the verdict and the comparison matrix."""
    sections = [verdict(findings), *completeness(findings)]
    return [*sections, _comparison(findings)] if findings.problems else sections


def closing_sections(findings: Findings) -> list[Section]:
    """Return what comes after them: distributions, convergence, tests, time and environment."""
    sections = [_environment(findings)]
    if findings.timing["trials"].any():
        sections = [_distributions(findings), _convergence(findings), *_tests(findings), _time(findings), *sections]
    return sections


def _comparison(findings: Findings) -> Section:
    matrix, summary = findings.matrix, findings.summary
    best, alike = matrix.best, matrix.alike
    text = []
    if best.to_numpy().any():
        unclear = int(alike.any(axis=1).sum())
        text.append(
            f"The lowest mean is {_shares(best)}. On {unclear or 'none'} of them the result of another optimizer may "
            "come from the best one’s distribution."
        )
        median = summary.pivot(index="problem", columns="optimizer", values="median").loc[best.index, best.columns]
        differ = int((best.any(axis=1) & ~(best & _is_lowest(median)).any(axis=1)).sum())
        if differ:
            text.append(
                f"On {count(differ, 'problem')} the lowest mean and the lowest median belong to different "
                "optimizers: a few trials sway the mean there, so look at the distributions."
            )
    means = Table(
        "comparison",
        "Mean of the best objective value over the trials of each cell (lower is better).",
        matrix.mean,
        bold=best,
        italic=alike,
        note=f"Bold: the lowest mean of the row. Italics: an exact Kolmogorov-Smirnov test at {ALPHA:g} (raw p, as "
        "in the thesis) cannot tell the result from the best one’s distribution. –: no mean, as trials failed or are "
        "missing.",
    )
    return Section("Comparison", tuple(text), (means,))


def _distributions(findings: Findings) -> Section:
    every = Table("cells", "Every cell: trials, failures and statistics of the best objective value.", findings.summary)
    box = findings.summary.assign(iqr=findings.summary["q3"] - findings.summary["q1"])
    width = box.pivot(index="problem", columns="optimizer", values="iqr").loc[findings.problems, findings.optimizers]
    text = (
        ()
        if len(findings.optimizers) < 2
        else (f"The narrowest middle half of the trials is {_shares(_is_lowest(width))}.",)
    )
    return Section("Distributions", text, items=(distribution_figure(findings), every))


def _convergence(findings: Findings) -> Section:
    figure = convergence_figure(findings)
    sentences = []
    for share in (0.01, 0.1, 1.0) if len(findings.optimizers) > 1 else ():
        spent = max(round(share * findings.results.study.budget), 1)
        reached = figure.data[figure.data["evaluations"] <= spent].groupby(["problem", "optimizer"], sort=False).last()
        median = reached["median"].unstack("optimizer")
        sentences.append(f"After {count(spent, 'evaluation')} the lowest median is {_shares(_is_lowest(median))}.")
    return Section("Convergence", (" ".join(dict.fromkeys(sentences)),) if sentences else (), (figure,))


def _is_lowest(table: pd.DataFrame) -> pd.DataFrame:
    """Return where a table holds its row's lowest finite value."""
    finite = table.where(np.isfinite(table.to_numpy(dtype=float)))
    return finite.eq(finite.min(axis=1), axis=0)


def _shares(marks: pd.DataFrame) -> str:
    """Return in words how often each column is marked, of the rows with any mark; ties count for each."""
    totals = marks.sum().sort_values(ascending=False, kind="stable")
    shares = [f"{label}’s on {number}" for label, number in totals.items() if number]
    return f"{listing(shares)} of {count(int(marks.any(axis=1).sum()), 'problem')}" if shares else "not known"


def _tests(findings: Findings) -> list[Section]:
    pairs = findings.pairs
    if pairs.empty:
        return []
    significant = int(pairs["significant"].astype(bool).sum())
    text = (
        f"Of {count(len(pairs), 'pair')}, {significant} differ significantly after Holm’s adjustment within their "
        f"problem (alpha = {ALPHA:g}), {int((pairs['p'] <= ALPHA).sum())} before it. D is the largest distance "
        "between the two empirical distributions; p is exact. A12 is the chance that a trial of the first optimizer "
        "ends below one of the second, ties counted half: 0.5 is no tendency, and beyond 0.56, 0.64 and 0.71 (below "
        "0.44, 0.36 and 0.29) it is called small, medium and large."
    )
    names = {
        "first": "first", "second": "second", "distance": "D", "p": "p", "p_holm": "p (Holm)",
        "significant": "significant", "a12": "A12", "lower": "tends lower", "testable": "testable", "tied": "tied > "
        "10%",
    }  # fmt: skip
    tables = [
        Table(
            f"tests-{problem}",
            f"{problem}: every pair of optimizers.",
            pairs.loc[pairs["problem"] == problem, list(names)].rename(columns=names),
            decimals={"D": 3, "A12": 3},
        )
        for problem in findings.problems
    ]
    return [Section("Pairwise tests", (text,), tuple(tables))]


def _time(findings: Findings) -> Section:
    timing = findings.timing
    known = timing[timing["trials"] > 0].sort_values("wall_mean", kind="stable")
    fastest, slowest = known.iloc[0], known.iloc[-1]
    text = [f"A trial takes {seconds(fastest['wall_mean'])} on average with {fastest['optimizer']}"]
    if len(known) > 1:
        text[0] += f", the fastest, and {seconds(slowest['wall_mean'])} with {slowest['optimizer']}, the slowest"
    text[0] += ". Times are those of the machine below, one trial a core."
    warnings = []
    if len(waited := known.loc[known["contention"], "optimizer"]):
        warnings.append(
            f"Trials of {listing(list(waited))} waited for their core (wall time more than {CONTENTION:g} times CPU "
            "time): the machine was busy, so trust CPU times rather than wall times."
        )
    if len(threaded := known.loc[known["hidden_threads"], "optimizer"]):
        warnings.append(
            f"Trials of {listing(list(threaded))} used more than one core (CPU time more than {HIDDEN_THREADS:g} "
            "times wall time): wall times flatter them."
        )
    shown = pd.DataFrame(
        {
            "trials": timing["trials"],
            "wall s": timing["wall_median"],
            "wall IQR": _interval(timing, "wall"),
            "CPU s": timing["cpu_median"],
            "CPU IQR": _interval(timing, "cpu"),
            "objective": timing["objective_share"].map("{:.0%}".format, na_action="ignore"),
            "evals/s": timing["speed_median"],
            "evals/s IQR": _interval(timing, "speed"),
            "wall/CPU": timing["wall_per_cpu"],
        }
    ).set_index(pd.Index(timing["optimizer"], name="optimizer"))
    table = Table(
        "timing",
        "Median time of one trial, its quartiles, the share spent in the problem’s evaluate, and evaluations a second.",
        shown,
        decimals={"wall/CPU": 2, "evals/s": 0},
        data=timing,
    )
    return Section("Time", tuple(text), (timing_figure(timing), table), tuple(warnings))


def _interval(timing: pd.DataFrame, name: str) -> list[str]:
    quartiles = zip(timing[f"{name}_q1"], timing[f"{name}_q3"], strict=True)
    return ["–" if pd.isna(q1) else f"{_short(q1)}–{_short(q3)}" for q1, q3 in quartiles]


def _short(value: float) -> str:
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def _environment(findings: Findings) -> Section:
    study, environments = findings.results.study, findings.results.environments
    seeds = findings.frame["seed"]
    text = (
        f"The study’s seed is {study.seed}; each trial’s own seed is a hash of it, the problem, the optimizer and "
        "the trial’s number, and stands in figures/distributions.csv. A trial is repeated by bench.solve with its "
        "seed and the same options and budget."
    )
    warnings = []
    if len(seeds) and seeds.duplicated().any():
        warnings.append("Some trials share a seed, so they are not independent.")
    if not environments:
        warnings.append("The folder holds no note of the machine that ran it.")
    machines = {
        json.dumps([e.get(k) for k in ("processor", "python", "packages", "git")], default=str) for e in environments
    }
    if len(machines) > 1:
        warnings.append(f"The trials come from {len(machines)} different environments; compare times with care.")
    entries = pd.DataFrame(
        [
            {"kind": kind, "label": entry.label, "plug-in": entry.name, "options": _options(entry.options)}
            for kind, group in (("optimizer", study.optimizers), ("problem", study.problems))
            for entry in group
        ]
    )
    items = [Table("entries", "What was compared, and with which options (all others are the defaults).", entries)]
    if environments:
        runs = pd.DataFrame({f"run {i + 1}": _flat(run) for i, run in enumerate(environments)}).rename_axis("item")
        items.append(Table("environment", "Where each run was made.", runs))
    return Section("Environment and seeds", (text,), tuple(items), tuple(warnings))


def _options(options: dict[str, Any]) -> str:
    return ", ".join(f"{key} = {json.dumps(value, default=str, ensure_ascii=False)}" for key, value in options.items())


def _flat(run: dict[str, Any]) -> dict[str, str]:
    """Return a nested note as one level: ``packages numpy`` and so on."""
    flat: dict[str, str] = {}
    for key, value in run.items():
        if isinstance(value, dict):
            flat |= {f"{key} {name}": text for name, text in _flat(value).items()}
        else:
            flat[key] = "" if value is None else str(value)
    return flat
