"""Replace a damaged store by one of its sound trials, so that a run makes only the others again."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import suppress
from typing import Any

from bench.errors import BenchError
from bench.helpers.atomic import replacing
from bench.storage.folder import Folder
from bench.storage.merge import copy
from bench.storage.reading import StoreCheck
from bench.storage.store import BEYOND_REPAIR, FILE, DamagedStoreError, Store

ASIDE = f"{FILE}.damaged"
"""The copy of the last damaged store."""


def repair(folder: Folder, trials: int) -> str:
    """Check the store of a locked folder and replace a damaged one; return a sentence on it, "" for a sound one.

    A damaged store is kept beside the new one. The lost trials are missing from the new one, and rows whose
    environment's record is lost refer to none.

    Args:
        folder: the study's folder.
        trials: the study's number of trials in each cell.

    Raises:
        BenchError: when the store is damaged beyond repair.
    """
    store = folder.store
    try:
        check = store.check(structure=True)
    except DamagedStoreError as error:
        check = StoreCheck(structure=str(error.__cause__))
    if check.sound:
        folder.note_store(check)
        return ""
    there = store.exists
    try:
        with replacing(store.path) as temporary:
            with Store(folder.path, temporary.name).writer(anew=True) as writer, store.reader(rescue=True) as reader:
                cells, environments = reader.cells, dict[int, dict[str, Any]]()
                with suppress(sqlite3.DatabaseError):
                    environments = reader.environments(folder.copied_environments())
                kept, _ = copy(reader.rescue(trials), cells, environments, writer, str(store.path))
                writer.select(cells.study, cells.looks, cells.by_labels)
            if there:
                shutil.copy(store.path, folder.path / ASIDE)
            for beside in ("-wal", "-shm"):  # of the damaged store; the new one has none
                store.path.with_name(FILE + beside).unlink(missing_ok=True)
    except DamagedStoreError as error:
        raise BenchError(f"the store {store.path} cannot be used: {error.__cause__}; {BEYOND_REPAIR}") from error
    folder.note_store(StoreCheck(kept))
    aside = f", and the damaged store is now {ASIDE}" if there else ""
    return f"{check.sentence}; {kept:,} sound trials are kept{aside}"
