"""Unpack a tar or zip archive into a folder, within limits: archives of strangers may hold anything."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import re
import shutil
import stat
import tarfile
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from pathlib import Path, PurePosixPath
from typing import IO

from bench.helpers.errors import BenchError
from bench.helpers.text import printable

MOST_GB = 4.0
"""10⁹ bytes that are read of a folder or unpacked from an archive, unless a larger limit is given."""

MOST_FILES = 200_000
"""Files that are looked at."""

BOMB = 200  # an archive that grows by more than this factor is a bomb …
HARMLESS = 200_000_000  # … unless it unpacks to less than these bytes

_CHUNK = 1 << 20
_PADDING = 64  # chunks after the last member of an archive
_LONGEST = 100  # characters shown of a name, which may hold anything
_DAMAGED = (tarfile.TarError, zipfile.BadZipFile, zlib.error, lzma.LZMAError)

Member = tuple[str, int, IO[bytes] | None]
"""Name, size and content of a member of an archive that is no folder; None stands for a link or a device."""


def extract(
    path: Path,
    members: Iterable[Member],
    folder: Path,
    most_gb: float = MOST_GB,
    remedy: str = "import a part of it at a time",
) -> list[str]:
    """Write the members of an archive into a folder and return their names; no more bytes than they declare are read.

    Raises:
        BenchError: where the archive is damaged, cut short or too large, or grows as no results do, and where it holds
            links or paths that leave it.
        OSError: where the folder cannot be written.
    """
    names: list[str] = []
    size = 0
    try:
        for name, declared, content in members:
            shown = f"{path.name} holds {printable(name, _LONGEST)!r}"
            if content is None:
                raise BenchError(f"{shown}, which is a link, a folder or a device; it is not unpacked")
            parts = PurePosixPath(name.replace("\\", "/")).parts
            if not parts or ".." in parts or parts[0].startswith("/") or ":" in parts[0]:
                raise BenchError(f"{shown}, a path that leaves the archive; it is not unpacked")
            names.append(name)
            size += declared
            refuse_excess(path.name, len(names), size, most_gb, remedy)
            if size > HARMLESS and size > BOMB * path.stat().st_size:
                raise _bomb(path.name)
            target = folder.joinpath(*parts)
            target.parent.mkdir(parents=True, exist_ok=True)
            with target.open("wb") as file:
                shutil.copyfileobj(content, file, _CHUNK)
    except (*_DAMAGED, EOFError, OSError, NotImplementedError, RuntimeError, ValueError) as error:
        if isinstance(error, BenchError) or getattr(error, "errno", None):  # the disk's, not the archive's
            raise
        raise BenchError(f"the archive {path} is damaged or cut short: {printable(str(error), _LONGEST)}") from error
    return names


def refuse_excess(
    name: str, files: int, size: int, most_gb: float = MOST_GB, remedy: str = "import a part of it at a time"
) -> None:
    """Raise BenchError for more files or bytes than results have."""
    if files > MOST_FILES or size > most_gb * 1e9:
        raise BenchError(f"{name} holds more than {MOST_FILES:,} files or {most_gb:g} GB; {remedy}")


def members_of(path: Path) -> Iterator[Member] | None:
    """Return the members of an archive, None for another file; an archive that was cut short is known by its name."""
    with suppress(EOFError, *_DAMAGED), closing(_Bounded(path)) as content, tarfile.TarFile(fileobj=content):
        return _tar_members(path)
    if zipfile.is_zipfile(path) or path.suffix == ".zip":
        return zip_members(path)
    return _tar_members(path) if re.search(r"\.(tgz|tar(\.\w+)?)$", path.name) else None


def zip_members(path: Path) -> Iterator[Member]:
    """Yield the members of a zip archive."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if stat.S_IFMT(member.external_attr >> 16) not in (0, stat.S_IFREG, stat.S_IFDIR * member.is_dir()):
                yield member.orig_filename, 0, None
            elif not member.is_dir():
                with archive.open(member) as content:
                    yield member.orig_filename, member.file_size, content


def _tar_members(path: Path) -> Iterator[Member]:
    with closing(_Bounded(path)) as bounded, tarfile.TarFile(fileobj=bounded) as archive:
        for member in archive:
            if not member.isdir():
                yield member.name, member.size, archive.extractfile(member) if member.isfile() else None
        for _ in range(_PADDING):  # a compressed file that was cut shows it only at its end
            if not bounded.read(_CHUNK):
                break


class _Bounded(io.RawIOBase):
    """The content of a tar archive, of which no more is unpacked than results hold, whatever its headers declare."""

    def __init__(self, path: Path) -> None:
        self._name, self._most = path.name, max(HARMLESS, BOMB * path.stat().st_size)
        for opened in (gzip.open, bz2.open, lzma.open, open):
            self._content: io.BufferedIOBase = opened(path, "rb")
            with suppress(OSError, EOFError, *_DAMAGED):
                self._content.read(1)
                break
            self._content.close()
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
        self._content.close()
        super().close()

    def _refuse_bomb(self, size: int) -> None:
        if size > self._most:
            raise _bomb(self._name)


def _bomb(name: str) -> BenchError:
    return BenchError(f"{name} unpacks to more than {BOMB} times its size, as no results do; it is not unpacked")
