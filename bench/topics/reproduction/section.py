"""The script that makes the numbers of the tables from the trials, and what it needs beside them."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

import numpy as np

from bench.analysis.cells import budgets
from bench.formats.tables.writer import improvements
from bench.helpers.text import file_name
from bench.report.parts import File
from bench.study.targets import COCO_PRECISIONS, KINDS, QUANTILES, Targets, fractions
from bench.topics.findings import Findings
from bench.topics.topic import Topic

TITLE = "Reproduction"
MOST_IMPROVEMENTS = 200_000  # rows of tables/traces.csv, about 12 MB; "bench export" writes more
RANKS = ["comparison", "comparison-precisions", "rank-map", "ranking"]
DECIDED = ["tests", "against-rivals", *RANKS, "pairs-over-problems", "pair-matrix"]
FINAL = ["cells", "competition", "competition-statistics", "regret", "interquartile-mean", *DECIDED]
ANYTIME = ["running-times", "success-rates", "target-sets", "aocc"]


def beside(findings: Findings) -> list[File]:
    """Return the script, the traces where they are not too many, and the facts that are no results."""
    if findings.trials.frame.empty:
        return []
    needed = json.dumps(facts(findings), indent=1) + "\n"
    script = files("bench.topics.reproduction").joinpath("reproduce.py.txt").read_text(encoding="utf-8")
    traces = findings.results.traces
    rows = sum(len(trace.values) for trace in traces.values())
    found = [
        File("reproduce.py", "A script that makes the numbers of the tables from the trials.", script),
        File("reproduce.json", "What that script needs beside the trials.", needed),
    ]
    if 0 < rows <= MOST_IMPROVEMENTS:
        about = "The improvements of all trials, one row an improvement."
        found.append(File("tables/traces.csv", about, improvements(findings.results)))
    return found


def facts(findings: Findings) -> dict[str, Any]:
    """Return the facts behind the tables, besides the trials: labels, optima, budgets, blocks, targets and levels."""
    trials, final, anytime = findings.trials, findings.final, findings.anytime
    cells = trials.whole[["problem", "optimizer"]].astype(object).drop_duplicates()
    allowed = dict(
        zip(zip(cells["problem"], cells["optimizer"], strict=True), budgets(cells, trials.allowed), strict=True)
    )
    optimum = {raw: findings.results.facts(raw).optimum for raws in trials.pooled.members.values() for raw in raws}
    sets = list(dict.fromkeys([anytime.target_set.short, *anytime.target_sets["set"]]))
    chosen = anytime.target_set
    return {
        "optimizers": trials.optimizers,
        "problems": {
            label: {
                "instances": {raw: optimum[raw] for raw in trials.pooled.members[label]},
                "budget": trials.budgets[label],
                "budgets": {name: allowed[label, name] for name in trials.optimizers if (label, name) in allowed},
                "dimension": trials.dimensions.get(label),
                "optimum": trials.optima.get(label),
                "block": trials.blocks[label],
                "shifts": {name: by for (problem, name), by in trials.shifts.items() if problem == label},
            }
            for label in trials.problems
        },
        "files": {file_name(label): label for label in trials.problems},
        "level_problems": final.levels.problems,
        "level_on_problems": final.level_on_problems,
        "level_across": final.levels.across,
        "subject": final.subject,
        "sets": {name: _rule(name, chosen) for name in sets},
        "targets": {
            "set": chosen.short,
            "unit": chosen.unit,
            "rising": chosen.rising,
            "levels": list(chosen.levels),
            "tabled": list(chosen.tabled),
            "given": {
                str(label): part[["tau", "target"]].to_numpy(dtype=float).tolist()
                for label, part in anytime.targets.groupby("problem", sort=False, observed=True)
            }
            if chosen.by_best
            else {},
        },
        "not_made": _not_made(findings),
    }


def _rule(name: str, chosen: Targets) -> dict[str, Any]:
    """Return how the script makes a set of targets, with its levels where the optimum is known, and where it is not."""
    if name == chosen.short and chosen not in KINDS.values():
        taus = np.array(getattr(chosen, "taus", ())).tolist()
        return {"kind": "precisions" if chosen.absolute else "percentages", "taus": [taus, taus]}
    ladders = {"relative": (fractions(True), fractions(False)), "quantiles": (QUANTILES, QUANTILES)}
    ladders["precisions"] = (COCO_PRECISIONS, COCO_PRECISIONS)
    return {"kind": name if name in ladders else "given", "taus": [taus.tolist() for taus in ladders.get(name, ())]}


def _not_made(findings: Findings) -> dict[str, str]:
    """Return why the script leaves out tables of studies that do not compare all trials as they are stored."""
    compared = findings.trials.comparable
    left: dict[str, str] = {}
    if findings.anytime.target_set.by_metric:
        left |= dict.fromkeys(ANYTIME, "its targets are those of metrics")
    if findings.results.study.looks:
        left |= dict.fromkeys(DECIDED, "declared looks decide which trials it has")
    if compared.common or compared.unknown:
        left |= dict.fromkeys(FINAL, "its values are those at the largest budget that all optimizers had")
    if compared.failed or compared.instances:
        left |= dict.fromkeys((*FINAL, *ANYTIME), "it leaves out trials on problems that failed or are not shared")
    return left


TOPIC = Topic(TITLE, lambda _: None, place=740, files=beside)
