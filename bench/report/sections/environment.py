"""What was compared, on which data, with which seeds and on which machine."""

from __future__ import annotations

import json
from typing import Any

import pandas as pd

from bench.report.findings import Findings
from bench.report.parts import Section, Table
from bench.report.words import options
from bench.study import Study

TITLE = "Environment, seeds and data"


def section(findings: Findings) -> Section:
    """Return the entries with their options, the hashes of the data, and each run's environment."""
    results = findings.results
    environments = results.environments
    seeds = (
        f"The study’s seed is {results.study.seed}; each trial’s own seed is a hash of it, the problem, the optimizer "
        "and the trial’s number, and stands in trials.csv. A trial is repeated by bench.solve with its seed and the "
        "same options and budget."
    )
    warnings = []
    if not environments:
        warnings.append("The folder holds no note of the machine that ran it.")
    machines = {
        json.dumps([e.get(k) for k in ("processor", "python", "packages", "git")], default=str) for e in environments
    }
    if len(machines) > 1:
        warnings.append(f"The trials come from {len(machines)} different environments; compare times with care.")
    items = [_entries(results.study)]
    if known := {label: value for label, value in results.fingerprints.items() if value}:
        hashes = pd.DataFrame({"SHA-256": known}).rename_axis("problem")
        items.append(Table("data", "The hash of every problem’s data when it ran.", hashes))
    if environments:
        runs = pd.DataFrame({f"run {i + 1}": _flat(run) for i, run in enumerate(environments)}).rename_axis("item")
        items.append(Table("environment", "Where each run was made.", runs))
    return Section(TITLE, (seeds,), tuple(items), tuple(warnings))


def _entries(study: Study) -> Table:
    entries = pd.DataFrame(
        [
            {"kind": kind, "label": entry.label, "plug-in": entry.name, "options": options(entry.options)}
            for kind, group in (("optimizer", study.optimizers), ("problem", study.problems))
            for entry in group
        ]
    )
    return Table("entries", "What was compared, and with which options (all others are the defaults).", entries)


def _flat(run: dict[str, Any]) -> dict[str, str]:
    """Return a nested note as one level: ``packages numpy`` and so on."""
    flat: dict[str, str] = {}
    for key, value in run.items():
        if isinstance(value, dict):
            flat |= {f"{key} {name}": text for name, text in _flat(value).items()}
        else:
            flat[key] = "" if value is None else str(value)
    return flat
