"""Unpack an archive into a new folder, all of it verified, or nothing of it."""

from __future__ import annotations

import hashlib
import re
import shutil
import stat
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from zlib import error as ZlibError  # noqa: N812 - zlib calls it error

from bench.errors import BenchError
from bench.formats.archive.contents import CRATE, REQUIRED, SUMS, belongs
from bench.formats.archive.crate import listed
from bench.helpers.atomic import replacing
from bench.helpers.parsing import parse_json
from bench.helpers.text import printable
from bench.storage.folder import Folder

BLOCK = 1 << 20  # bytes written at a time
MOST_FILES = 50_000
LARGEST_GB = 20.0  # of all files unpacked, unless a larger limit is given
LARGEST_LIST = 50_000_000  # bytes of the description and of the checksums, which are read into memory
BOMB = 200  # an archive that grows by more than this factor is a bomb …
HARMLESS = 200_000_000  # … unless it unpacks to less than these bytes
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

    Every file must be listed with its SHA-256 in the checksums and in the description, and have it; the trials must
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
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        raise BenchError(f"{target} is there already; give a new folder by --output")
    if source.exists() and not source.is_file():
        raise BenchError(f"{source} is no file; give an archive that 'bench pack' wrote")
    try:
        with zipfile.ZipFile(source) as archive:
            entries = _entries(archive, source, limit_gb)
            sums = _sums(_read(archive, entries, SUMS, source), source)
            _compare(entries, sums, source)
            _describes(_read(archive, entries, CRATE, source), sums, source)
            target.parent.mkdir(parents=True, exist_ok=True)
            _refuse_full_disk(target, entries)
            with replacing(target) as temporary:
                temporary.mkdir()
                for name in sorted(sums):
                    _extract(archive, entries[name], temporary / name, sums[name], source)
                (temporary / SUMS).write_bytes(_read(archive, entries, SUMS, source))
                trials, sentence = _checked(temporary, source)
    except zipfile.BadZipFile as error:
        raise BenchError(f"{source} is no zip archive, or a damaged one: {_said(error)}") from error
    except OSError as error:
        raise BenchError(f"{error.filename or source} cannot be used: {error.strerror or error}") from error
    return Unpacked(target, len(entries), trials, sentence)


def _entries(archive: zipfile.ZipFile, source: Path, limit_gb: float) -> dict[str, zipfile.ZipInfo]:
    """Return the archive's entries by name; raises BenchError where one is no plain file of a name that we write."""
    entries: dict[str, zipfile.ZipInfo] = {}
    folded: set[str] = set()
    members = archive.infolist()
    if len(members) > MOST_FILES:
        raise BenchError(f"{source} holds {len(members):,} files; an archive of results has at most {MOST_FILES:,}")
    for entry in members:
        shown = repr(printable(entry.orig_filename, LONGEST))
        kind = stat.S_IFMT(entry.external_attr >> 16)
        if kind not in (0, stat.S_IFREG) or entry.is_dir():
            raise BenchError(f"{source} holds {shown}, which is a link, a folder or a device; it is not unpacked")
        if entry.flag_bits & 0x1:
            raise BenchError(f"{source} holds {shown}, which is encrypted; it is not unpacked")
        if entry.orig_filename not in (SUMS, CRATE) and not belongs(entry.orig_filename):
            raise BenchError(f"{source} holds {shown}, which is no file of an archive of results; it is not unpacked")
        if entry.filename.lower() in folded:  # some file systems do not distinguish capitals
            raise BenchError(f"{source} holds {shown} twice; it is not unpacked")
        folded.add(entry.filename.lower())
        entries[entry.filename] = entry
    size, packed = sum(entry.file_size for entry in members), max(source.stat().st_size, 1)
    if size > limit_gb * 1e9:
        raise BenchError(
            f"{source} unpacks to {size / 1e9:,.1f} GB, more than the limit of {limit_gb:g} GB; --limit raises it"
        )
    if size > HARMLESS and size > BOMB * packed:
        raise BenchError(
            f"{source} unpacks to {size / packed:,.0f} times its size, as no results do; it is not unpacked"
        )
    return entries


def _read(archive: zipfile.ZipFile, entries: Mapping[str, zipfile.ZipInfo], name: str, source: Path) -> bytes:
    """Return the content of one of the two lists."""
    if name not in entries:
        raise BenchError(f"{source} has no {name}, so it is no archive that 'bench pack' wrote")
    if entries[name].file_size > LARGEST_LIST:
        raise BenchError(f"{source}: {name} is too large to be a list of files")
    try:
        return archive.read(entries[name])
    except (zipfile.BadZipFile, NotImplementedError, EOFError, ZlibError) as error:
        raise BenchError(f"{source}: {name} is damaged ({_said(error)}); get the archive again") from error


def _sums(content: bytes, source: Path) -> dict[str, str]:
    """Return the SHA-256 of every file by name."""
    sums: dict[str, str] = {}
    for number, line in enumerate(content.decode(errors="replace").splitlines(), start=1):
        match = _SUM.fullmatch(line)
        if match is None or match[2] in sums:
            raise BenchError(f"{source}: line {number} of {SUMS} is malformed; get the archive again")
        sums[match[2]] = match[1]
    return sums


def _compare(entries: Mapping[str, object], sums: Mapping[str, str], source: Path) -> None:
    """Raise BenchError where files are missing or were added."""
    for name in (*REQUIRED, CRATE, *sums):
        if name not in entries:
            raise BenchError(f"{source}: {printable(name, LONGEST)} is missing; get the archive again")
    for name in entries:
        if name != SUMS and name not in sums:
            raise BenchError(f"{source}: {name} was added, as {SUMS} does not list it; get the archive again")


def _describes(content: bytes, sums: Mapping[str, str], source: Path) -> None:
    """Raise BenchError where the description does not list the files of the checksums, with the same hashes."""
    try:
        described: dict[str, str] = listed(parse_json(content))
    except ValueError as error:
        raise BenchError(f"{source}: {CRATE} is no JSON; get the archive again") from error
    payload = {name: digest for name, digest in sums.items() if name != CRATE}
    if different := sorted({name for name, _ in described.items() ^ payload.items()}):
        raise BenchError(
            f"{source}: {CRATE} and {SUMS} disagree on {printable(different[0], LONGEST)}; get the archive again"
        )


def _refuse_full_disk(target: Path, entries: Mapping[str, zipfile.ZipInfo]) -> None:
    size, free = sum(entry.file_size for entry in entries.values()), shutil.disk_usage(target.parent).free
    if size > free:
        raise BenchError(f"{target} needs {size / 1e9:,.1f} GB, and {free / 1e9:,.1f} GB of the disk are free")


def _extract(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, path: Path, digest: str, source: Path) -> None:
    """Write one file, and compare what was written with its hash."""
    path.parent.mkdir(exist_ok=True)
    sha256, size = hashlib.sha256(), 0
    try:
        with archive.open(entry) as content, path.open("xb") as file:
            while block := content.read(BLOCK):
                size += len(block)
                if size > entry.file_size:
                    raise BenchError(f"{source}: {entry.filename} is longer than declared; get the archive again")
                sha256.update(block)
                file.write(block)
    except (zipfile.BadZipFile, NotImplementedError, EOFError, ZlibError) as error:
        raise BenchError(f"{source}: {entry.filename} is damaged ({_said(error)}); get the archive again") from error
    if sha256.hexdigest() != digest:
        raise BenchError(f"{source}: {entry.filename} was changed: its SHA-256 is not that of {SUMS}")


def _checked(temporary: Path, source: Path) -> tuple[int, str]:
    """Read what was unpacked as any folder is read; return the number of its trials, and what their digests say."""
    folder = Folder(temporary)
    try:
        study = folder.study()
        folder.fingerprints()
        health = folder.store.check(structure=True)
        cells = folder.store.cells()
    except BenchError as error:
        sentence = str(error).replace(f"{temporary.resolve()}/", "").replace(f"{temporary}/", "")
        raise BenchError(f"{source}: {sentence}") from error
    if not health.sound:
        raise BenchError(f"{source}: {health.sentence}")
    problems, optimizers = ({entry.label for entry in part} for part in (study.problems, study.with_controls))
    if strange := [cell for cell in cells if cell.problem not in problems or cell.optimizer not in optimizers]:
        where = printable(f"{strange[0].optimizer} on {strange[0].problem}", LONGEST)
        raise BenchError(f"{source}: it holds trials of {where}, which its study does not name")
    folder.note_store(health)
    return health.trials, health.sentence


def _said(error: Exception) -> str:
    return printable(str(error).strip() or type(error).__name__, LONGEST)
