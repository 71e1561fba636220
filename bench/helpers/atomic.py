"""Write a file or a folder atomically: a kill or an error leaves the old one or the new one, never a part."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bench.helpers.errors import BenchError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path``; the file or folder made there replaces ``path`` when the context ends.

    After an error it is removed and ``path`` is unchanged.

    Raises:
        BenchError: where it cannot be written, or would replace the working folder, a device, a pipe or a socket.
    """
    if not path.name:
        raise BenchError(f"{path} cannot be replaced while it is in use; give the name of another file or folder")
    if os.path.exists(path) and not (path.is_file() or path.is_dir()):  # noqa: PTH110 - it never raises
        raise BenchError(f"{path} cannot be written: it is neither a file nor a folder")
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp{path.suffix}")
    try:
        yield temporary
        if temporary.is_dir() and path.is_dir():
            shutil.rmtree(path)
        temporary.replace(path)
    except OSError as error:
        raise BenchError(f"{path} cannot be written: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            shutil.rmtree(temporary) if temporary.is_dir() else temporary.unlink(missing_ok=True)


def names_in(folder: Path) -> set[str]:
    """Return the names of what a folder to be written holds already: none in a new one, its own for a file.

    Raises:
        BenchError: where it cannot be read.
    """
    try:
        return {entry.name for entry in folder.iterdir()}
    except FileNotFoundError:
        return set()
    except NotADirectoryError:
        return {folder.name}
    except OSError as error:
        raise BenchError(f"{folder} cannot be read: {error.strerror}") from error
