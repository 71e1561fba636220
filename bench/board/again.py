"""Make trials of an unpacked archive again, in a sandbox, each in a study of its own problem and optimizer alone."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

from bench.board.archive import LONGEST, Again
from bench.errors import BenchError
from bench.execution.again import difference
from bench.execution.runner import prepare
from bench.execution.supervisor import make_one
from bench.execution.verify import HASH_SEED
from bench.helpers.text import printable
from bench.seeds import trial_seed
from bench.storage.folder import Folder
from bench.study import Study
from bench.trial import Trial


def make_again(path: Path, trials: int, choice: str) -> tuple[Again, ...]:
    """Make some finished trials of a folder again and return the outcomes.

    They are drawn at random from ``choice``, the hash of the archive, and their seeds follow from the study's, so that
    the author of an archive chooses neither. A trial that cannot be made here costs no other one: each is of a study
    that has its problem and optimizer alone, which changes no seed.
    """
    folder = Folder(path)
    study = folder.study()
    labels = {entry.label for entry in study.optimizers}
    with folder.store.reader() as reader:
        every = [(row["problem"], row["optimizer"], row["trial"]) for row in reader.sound("status = 'ok'")]
    finished = sorted(key for key in every if key[1] in labels)
    chosen = random.Random(choice).sample(finished, min(trials, len(finished)))
    seeds = {shown: cell.labels for shown, cell in folder.store.held().by_labels.items()}
    return tuple(_again(folder, study, Trial(*key, trial_seed(study.seed, *seeds[key[:2]], key[2]))) for key in chosen)


def _again(folder: Folder, study: Study, trial: Trial) -> Again:
    name = printable(f"{trial.optimizer} on {trial.problem}, trial {trial.number}", LONGEST)
    alone = replace(
        study,
        problems=tuple(entry for entry in study.problems if entry.label == trial.problem),
        optimizers=tuple(entry for entry in study.optimizers if entry.label == trial.optimizer),
        controls=(),
        looks=(),
    )
    try:
        checked = prepare(alone, folder, untrusted=True)
        folder.require_unchanged(alone, checked.fingerprints)
        row = make_one(replace(checked.task, hash_seed=HASH_SEED), trial)
    except BenchError as error:
        return Again(name, reason=_one_line(str(error).replace(str(folder.path), "the archive")))
    if row["status"] != "ok":
        return Again(name, reason=_one_line(str(row["error"])))
    return Again(name, different=_one_line(difference(folder.store, trial, row)))


def _one_line(text: str) -> str:
    return printable(text.partition("\n")[0], 2 * LONGEST)
