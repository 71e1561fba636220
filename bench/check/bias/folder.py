"""Diagnose all optimizers of a study and store the verdicts in its folder for reports."""

from __future__ import annotations

from bench.check.bias import diagnose
from bench.check.verdict import Verdict
from bench.errors import BenchError
from bench.storage.folder import Folder


def diagnose_folder(folder: Folder, n_jobs: int = -1) -> tuple[dict[str, list[Verdict]], dict[str, str]]:
    """Diagnose every optimizer of a study with its own options, and store the verdicts in the folder.

    Returns:
        the verdicts by optimizer label, and why an optimizer could not be diagnosed, by label.
    """
    study = folder.study()
    found: dict[str, list[Verdict]] = {}
    failed: dict[str, str] = {}
    for entry in study.optimizers:
        try:
            found[entry.label] = diagnose(study.optimizer(entry.label), n_jobs=n_jobs)
        except BenchError as error:  # the other optimizers get their verdicts all the same
            failed[entry.label] = str(error)
    folder.note_checks({label: [each.as_dict() for each in verdicts] for label, verdicts in found.items()})
    return found, failed
