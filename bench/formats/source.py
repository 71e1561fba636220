"""Open what is imported: a folder, a file, or an archive that is unpacked into a temporary folder."""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from bench.formats.unpacking import extract, members_of, refuse_excess
from bench.helpers.errors import BenchError


@dataclass(frozen=True)
class Source:
    """The folder, file or archive that is imported.

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
        elif path.suffix.lower() != ".xlsx" and (members := members_of(path)):
            with tempfile.TemporaryDirectory(prefix="bench-import-") as temporary:
                extract(path, members, Path(temporary))
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
            refuse_excess(name, len(files), size)
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


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file; raises BenchError where it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise BenchError(f"{path} cannot be read: {error.strerror}") from error
