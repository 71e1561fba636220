"""Write a study's folder into one archive; the same folder gives the same bytes."""

from __future__ import annotations

import hashlib
import stat
import tempfile
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from bench.formats.archive.contents import NOTES, SUMS, report_files
from bench.helpers.atomic import replacing
from bench.helpers.errors import BenchError
from bench.storage.folder import ANSWER, ENVIRONMENT, STUDY, VERIFICATION, Folder
from bench.storage.store import FILE as TRIALS
from bench.storage.store import Store
from bench.study import Study

BLOCK = 1 << 20  # bytes read at a time
EPOCH = (1980, 1, 1, 0, 0, 0)  # the first date that a zip file knows
LEVEL = 6  # of deflate


@dataclass(frozen=True)
class Packed:
    """The outcome of packing: the archive, the numbers of its files and trials, and sentences on what it lacks."""

    path: Path
    files: int
    trials: int
    notes: tuple[str, ...] = ()


def pack(path: str | PathLike[str], output: str | PathLike[str] | None = None) -> Packed:
    """Write a study's folder into one zip file: trials, frozen study, environments, report and hashes.

    The trials are a consistent copy, also while a run adds to them. The folder is not changed.

    Args:
        path: the folder that ``bench.run`` wrote.
        output: the archive; by default a file beside the folder, of its name with ``.zip``.

    Raises:
        BenchError: when the folder holds no study or damaged trials, a part of its report is missing, or the archive
            cannot be written.
    """
    folder = Folder(path)
    study = folder.study()
    here = folder.path.resolve()
    target = Path(output) if output is not None else here.with_name(f"{here.name}.zip")
    if target.is_dir():
        raise BenchError(f"{target} is a folder; give the path of a file to write")
    if target.exists() and not (target.is_file() and zipfile.is_zipfile(target)):
        raise BenchError(f"{target} is another file than an archive; give another --output")
    folder.checks(), folder.noted(VERIFICATION)  # raise where a note is damaged
    reported = report_files(folder.path)
    with replacing(target) as temporary:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".pack-") as place:
            copy = _copied(folder, Path(place))
            sources = {name: folder.path / name for name in [STUDY, *NOTES, *reported] if (folder.path / name).exists()}
            sources |= {name: copy.path / name for name in (TRIALS, ENVIRONMENT)}
            if links := [name for name, source in sources.items() if source.is_symlink()]:
                raise BenchError(
                    f"{folder.path / links[0]} is a link, which an archive does not hold; put a file there"
                )
            trials = sum(cell.done + cell.failed for cell in copy.store.cells())
            with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
                sums = {name: _add(archive, name, sources[name]) for name in sorted(sources)}
                (copy.path / SUMS).write_bytes("".join(f"{sha256}  {name}\n" for name, sha256 in sums.items()).encode())
                _add(archive, SUMS, copy.path / SUMS)
    notes = _notes(folder, study, trials, reported=bool(reported))
    return Packed(target, len(sums) + 1, trials, tuple(notes))


def _copied(folder: Folder, place: Path) -> Folder:
    """Return a folder with a sound copy of the store, and the environments written out; neither has a path of here."""
    copy, draft = Folder(place), Store(place / "draft")
    draft.path.parent.mkdir()
    counted = folder.store.check_count()
    folder.store.copy(draft.path)
    with draft.writer() as writer:
        for number, record in draft.records("environments").items():
            if record.get("working_folder"):
                writer.change(number, record | {"working_folder": ""})
    draft.copy(copy.store.path)
    for health in (counted, copy.store.check(structure=True)):
        if not health.sound:
            raise BenchError(f"{folder.path}: {health.sentence}; only sound results are packed")
    copy.write_environments()
    return copy


def _add(archive: zipfile.ZipFile, name: str, source: Path) -> str:
    """Add a file under an entry that depends on name and content alone; return the SHA-256 of the bytes added."""
    entry = zipfile.ZipInfo(name, EPOCH)
    entry.create_system = 3  # Unix, on every system
    entry.external_attr = (stat.S_IFREG | 0o644) << 16
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.file_size = source.stat().st_size  # so that a file of more than 2 GB gets the fields that it needs
    digest = hashlib.sha256()
    with source.open("rb") as file, archive.open(entry, "w") as packed:
        while block := file.read(BLOCK):
            digest.update(block)
            packed.write(block)
    return digest.hexdigest()


def _notes(folder: Folder, study: Study, trials: int, *, reported: bool) -> Iterator[str]:
    """Yield a sentence for everything that a reader of the archive would miss."""
    planned = len(study.problems) * len(study.optimizers) * study.trials
    if folder.running():
        yield "a run is writing to this folder; the archive holds the trials that it had finished"
    if trials < planned:
        yield f"{planned - trials:,} of the study's {planned:,} trials are missing"
    if not reported:
        yield f"the archive has no report, as there is none in the folder; 'bench report {folder.path}' writes it"
    elif folder.noted(ANSWER).get("state", "") not in ("", folder.store.state()):
        yield f"the report is older than the trials; 'bench report {folder.path}' writes it again"
