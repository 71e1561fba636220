"""Open what is imported: a folder, a file, or an archive that is unpacked into a temporary folder within limits."""

from __future__ import annotations

import bz2
import gzip
import hashlib
import io
import lzma
import re
import shutil
import tarfile
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO, Any

from bench.errors import BenchError
from bench.formats.archive.unpack import BOMB, HARMLESS

MOST_BYTES = 4 * 10**9
"""Bytes that are read of a folder or unpacked from an archive."""

MOST_FILES = 200_000
"""Files that are looked at."""

_CHUNK = 1 << 20
_PADDING = 64  # chunks after the last member of an archive
_DAMAGED = (tarfile.TarError, zipfile.BadZipFile, zlib.error, lzma.LZMAError)


@dataclass(frozen=True)
class Source:
    """What is imported.

    Attributes:
        name: the name of the folder or file.
        root: the folder that holds the files, which may be temporary.
        files: their paths within it, sorted, f2 before f10.
        sha256: the hash of the file or archive; of a folder, that of the paths and contents of its files.
    """

    name: str
    root: Path
    files: tuple[PurePosixPath, ...]
    sha256: str

    def bytes(self, file: PurePosixPath) -> bytes:
        """Return a file's content."""
        try:
            return (self.root / file).read_bytes()
        except OSError as error:
            raise BenchError(f"{self.name}/{file} cannot be read: {error.strerror}") from error

    def text(self, file: PurePosixPath) -> str:
        """Return a file's text; old files may hold bytes that are no UTF-8."""
        return self.bytes(file).decode("utf-8-sig", errors="replace")


@contextmanager
def opened(path: Path) -> Iterator[Source]:
    """Yield the files of a folder, of one file, or of a tar or zip archive.

    Raises:
        BenchError: where it is missing, cannot be read or is damaged, is too large, or holds links or paths that leave
            the archive.
    """
    try:
        if path.is_dir():
            yield _folder(path.resolve().name or str(path), path, "")
        elif not path.is_file():
            raise BenchError(f"{path} is neither a folder nor a file; give the results to import")
        elif members := _archive_reader(path):
            with tempfile.TemporaryDirectory(prefix="bench-import-") as temporary:
                _unpack(path, members(path), Path(temporary))
                yield _folder(path.name, Path(temporary), sha256_of(path))
        else:
            yield Source(path.name, path.parent, (PurePosixPath(path.name),), sha256_of(path))
    except OSError as error:
        raise BenchError(f"{path} cannot be read: {error.strerror or error}") from error


def _folder(name: str, root: Path, sha256: str) -> Source:
    files, size = [], 0
    for file in root.rglob("*"):
        path = PurePosixPath(file.relative_to(root).as_posix())
        if file.is_file() and not any(part.startswith((".", "__MACOSX")) for part in path.parts):  # no data of tools
            files.append(path)
            size += file.stat().st_size
            _limit(name, len(files), size)
    files.sort(key=_natural)
    if not sha256:
        digest = hashlib.sha256()
        for path in files:
            digest.update(f"{path}\0{sha256_of(root / path)}\n".encode())
        sha256 = digest.hexdigest()
    return Source(name, root, tuple(files), sha256)


def _natural(file: PurePosixPath) -> list[str | int]:
    """Return a key by which f2 comes before f10; texts and numbers alternate."""
    return [int(part) if part.isdigit() else part for part in re.split(r"([0-9]+)", str(file))]


def _limit(name: str, files: int, size: int) -> None:
    if files > MOST_FILES or size > MOST_BYTES:
        raise BenchError(
            f"{name} holds more than {MOST_FILES:,} files or {MOST_BYTES / 1e9:g} GB; import a part of it at a time"
        )


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file; raises BenchError where it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise BenchError(f"{path} cannot be read: {error.strerror}") from error


class _Bounded(io.RawIOBase):
    """The content of a tar archive, of which no more is unpacked than results hold, whatever its headers declare."""

    def __init__(self, path: Path) -> None:
        self._name, self._most = path.name, max(HARMLESS, BOMB * path.stat().st_size)
        self._file = path.open("rb")
        self._content: Any = self._file
        for opened in (gzip.open, bz2.open, lzma.open):
            with suppress(OSError, EOFError, *_DAMAGED):
                self._file.seek(0)
                opened(self._file).read(1)
                self._file.seek(0)
                self._content = opened(self._file)
                break
        self._content.seek(0)

    def read(self, size: int = -1) -> bytes:
        self._refuse_bomb(self.tell() + max(size, 0))
        return bytes(self._content.read(size))

    def seek(self, place: int, whence: int = 0) -> int:
        self._refuse_bomb(place if whence == 0 else 0)
        return int(self._content.seek(place, whence))

    def tell(self) -> int:
        return int(self._content.tell())

    def close(self) -> None:
        self._file.close()
        super().close()

    def _refuse_bomb(self, size: int) -> None:
        if size > self._most:
            raise _bomb(self._name)


def _bomb(name: str) -> BenchError:
    return BenchError(f"{name} unpacks to more than {BOMB} times its size, as no results do; it is not unpacked")


Member = tuple[str, int, IO[bytes] | None]
"""Name, size and content of a member of an archive that is no folder; None stands for a link or a device."""


def _archive_reader(path: Path) -> Callable[[Path], Iterator[Member]] | None:
    """Return what reads an archive, None for another file; an archive that was cut short is known by its name."""
    with suppress(EOFError, *_DAMAGED), closing(_Bounded(path)) as content, tarfile.TarFile(fileobj=content):
        return _tar_members
    if zipfile.is_zipfile(path) or path.suffix == ".zip":
        return _zip_members
    return _tar_members if re.search(r"\.(tgz|tar(\.\w+)?)$", path.name) else None


def _tar_members(path: Path) -> Iterator[Member]:
    with closing(_Bounded(path)) as bounded, tarfile.TarFile(fileobj=bounded) as archive:
        for member in archive:
            if not member.isdir():
                yield member.name, member.size, archive.extractfile(member) if member.isfile() else None
        for _ in range(_PADDING):  # a compressed file that was cut shows it only at its end
            if not bounded.read(_CHUNK):
                break


def _zip_members(path: Path) -> Iterator[Member]:
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if not member.is_dir():
                with archive.open(member) as content:
                    yield member.filename, member.file_size, content


def _unpack(path: Path, members: Iterator[Member], folder: Path) -> None:
    """Write the members of an archive into a folder; both libraries read no more bytes of one than it declares."""
    files = size = 0
    try:
        for name, declared, content in members:
            target = _target(path, folder, name)
            if content is None:
                raise BenchError(f"{path.name} holds {name!r}, which is no file; links are not imported")
            files, size = files + 1, size + declared
            _limit(path.name, files, size)
            if size > HARMLESS and size > BOMB * path.stat().st_size:
                raise _bomb(path.name)
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("wb") as file:
                shutil.copyfileobj(content, file, _CHUNK)
    except BenchError:
        raise
    except (*_DAMAGED, EOFError, OSError, RuntimeError, ValueError) as error:
        raise BenchError(f"the archive {path} is damaged or cut short: {error}") from error


def _target(path: Path, folder: Path, name: str) -> Path:
    """Return where a member of an archive is unpacked; refuse a path that leaves the folder."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    if not parts or ".." in parts or parts[0].startswith("/") or ":" in parts[0]:
        raise BenchError(f"{path.name} holds {name!r}, a path that leaves the archive; it is not imported")
    return folder.joinpath(*parts)
