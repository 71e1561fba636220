"""Read the BibTeX of a study's optimizers where a report needs it, strangers' in processes that can be lost."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from bench.errors import BenchError
from bench.execution import trial_process
from bench.plugins import loading
from bench.sandbox import bubblewrap
from bench.sandbox.process import DiedError, LostError, Process, RemoteError, TimeExceededError
from bench.sandbox.server import FORKS
from bench.study import Study

LOADING = 60.0  # seconds for loading the optimizers of one package
_LOSSES = (TimeExceededError, DiedError, RemoteError, LostError)


def bibtex(study: Study, sandbox: str | None = None) -> dict[str, str]:
    """Return the BibTeX of each optimizer by label, "" where its plug-in is missing here or gives no text.

    Only the optimizers that come with the harness are imported here.

    Args:
        study: whose optimizers are meant.
        sandbox: in which the study was run; where it cannot be used here, strangers' optimizers are not read.
    """
    built_in = [entry.label for entry in study.optimizers if loading.is_built_in(entry.name)]
    strange = [labels for labels in study.packages().values() if not {*labels} & {*built_in}]
    found = {entry.label: "" for entry in study.optimizers}
    found |= _texts(trial_process.bibtex_of(study, built_in), built_in)
    if strange:
        with suppress(BenchError, *_LOSSES):
            command = bubblewrap.command(sandbox) if sandbox else ()
            with Process(0, forks=FORKS, command=command) as root:
                root.call(trial_process.begin, study.to_toml())
                for labels in strange:
                    with suppress(*_LOSSES), root.fork() as process:
                        found |= _texts(process.call(trial_process.bibtex, labels, seconds=LOADING), labels)
    return found


def _texts(answer: Any, labels: Iterable[str]) -> dict[str, str]:
    given = answer if isinstance(answer, dict) else {}
    return {label: given[label] for label in labels if isinstance(given.get(label), str)}
