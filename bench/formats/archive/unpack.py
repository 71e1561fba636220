"""Unpack an archive into a new folder, all of it verified, or nothing of it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from bench.formats.archive.contents import REQUIRED, SUMS, belongs
from bench.formats.source import sha256_of
from bench.formats.unpacking import Member, extract, zip_members
from bench.helpers.atomic import names_in, replacing
from bench.helpers.errors import BenchError
from bench.helpers.text import printable
from bench.storage.folder import Folder

LARGEST_GB = 20.0  # of all files unpacked, unless a larger limit is given
LARGEST_LIST = 50_000_000  # bytes of the checksums, which are read into memory
LONGEST = 100  # characters shown of a name, which may hold anything

_SUM = re.compile(r"([0-9a-f]{64})  (.+)")


@dataclass(frozen=True)
class Unpacked:
    """The outcome of unpacking: the folder, the numbers of its files and trials, and what its digests say of them."""

    path: Path
    files: int
    trials: int
    sentence: str


def unpack(file: str | PathLike[str], output: str | PathLike[str], *, limit_gb: float = LARGEST_GB) -> Unpacked:
    """Unpack an archive that :func:`bench.formats.archive.pack` wrote into a new folder, and verify all of it.

    Every file must be listed with its SHA-256 in the checksums, and have it; the trials must
    fit their digests. Where anything was changed, is missing or was added, nothing is unpacked. The checksums are in
    the archive: they show damage and careless changes. Who may have replaced the whole archive is shown by comparing
    its own hash with a published one.

    Args:
        file: the archive.
        output: the folder to write, which must not exist or be empty.
        limit_gb: the most that all files may take, in 10⁹ bytes.

    Raises:
        BenchError: for a file that is no such archive, or that was changed, and for a folder that cannot be written.
    """
    source, target = Path(file), Path(output)
    if names_in(target):
        raise BenchError(f"{target} is there already; give a new folder by --output")
    if not source.is_file():
        raise BenchError(f"{source} is no file; give an archive that 'bench pack' wrote")
    with replacing(target) as temporary:
        temporary.mkdir(parents=True)
        names = extract(source, _ours(zip_members(source), source), temporary, limit_gb, "--limit raises the size")
        sums = _sums(temporary, source)
        _compare(set(names), sums, source)
        for name, digest in sums.items():
            if sha256_of(temporary / name) != digest:
                raise BenchError(f"{source}: {name} was changed: its SHA-256 is not that of {SUMS}")
        trials, sentence = _read_whole(temporary, source)
    return Unpacked(target, len(names), trials, sentence)


def _ours(members: Iterable[Member], source: Path) -> Iterator[Member]:
    """Yield the members of an archive; raises BenchError for a name that we do not write, or that occurs twice."""
    folded: set[str] = set()
    for member in members:
        name, shown = member[0], repr(printable(member[0], LONGEST))
        if name != SUMS and not belongs(name):
            raise BenchError(f"{source} holds {shown}, which is no file of an archive of results; it is not unpacked")
        if name.lower() in folded:  # some file systems do not distinguish capitals
            raise BenchError(f"{source} holds {shown} twice; it is not unpacked")
        folded.add(name.lower())
        yield member


def _sums(folder: Path, source: Path) -> dict[str, str]:
    """Return the SHA-256 of every file by name, as the archive lists them."""
    if not (folder / SUMS).is_file():
        raise BenchError(f"{source} has no {SUMS}, so it is no archive that 'bench pack' wrote")
    if (folder / SUMS).stat().st_size > LARGEST_LIST:
        raise BenchError(f"{source}: {SUMS} is too large to be a list of files")
    sums: dict[str, str] = {}
    for number, line in enumerate((folder / SUMS).read_text("utf-8", errors="replace").splitlines(), start=1):
        match = _SUM.fullmatch(line)
        if match is None or match[2] in sums:
            raise BenchError(f"{source}: line {number} of {SUMS} is malformed; get the archive again")
        sums[match[2]] = match[1]
    return sums


def _compare(names: Set[str], sums: Mapping[str, str], source: Path) -> None:
    """Raise BenchError where files are missing or were added."""
    for name in sorted({*REQUIRED, *sums} - names):
        raise BenchError(f"{source}: {printable(name, LONGEST)} is missing; get the archive again")
    for name in sorted(names - {SUMS, *sums}):
        raise BenchError(f"{source}: {name} was added, as {SUMS} does not list it; get the archive again")


def _read_whole(temporary: Path, source: Path) -> tuple[int, str]:
    """Read what was unpacked as any folder is read; return the number of its trials, and what their digests say."""
    folder = Folder(temporary)
    try:
        study = folder.study()
        health = folder.store.check(structure=True)
        cells = folder.store.cells()
    except BenchError as error:
        sentence = str(error).replace(f"{temporary.resolve()}/", "").replace(f"{temporary}/", "")
        raise BenchError(f"{source}: {sentence}") from error
    if not health.sound:
        raise BenchError(f"{source}: {health.sentence}")
    problems, optimizers = ({entry.label for entry in part} for part in (study.problems, study.optimizers))
    if strange := [cell for cell in cells if cell.problem not in problems or cell.optimizer not in optimizers]:
        where = printable(f"{strange[0].optimizer} on {strange[0].problem}", LONGEST)
        raise BenchError(f"{source}: it holds trials of {where}, which its study does not name")
    return health.trials, health.sentence
