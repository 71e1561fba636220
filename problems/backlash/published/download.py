"""List, find, check and download the data files that the thesis's authors published."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote, urlsplit

from platformdirs import user_data_dir

from bench.helpers.errors import BenchError

REPOSITORY = "ElianaGiovannitti/Backlash-estimation"
COMMIT = "7c81edefe3e61479d234d5080d4627dbbf584733"
SOURCE = f"https://github.com/{REPOSITORY}/tree/{COMMIT}"
BASE_URL = f"https://raw.githubusercontent.com/{REPOSITORY}/{COMMIT}/"
LICENCE = "EUPL-1.2, the European Union Public Licence (https://eupl.eu/1.2/en/)"
VARIABLE = "BENCH_PUBLISHED_DATA"
TIMEOUT = 30  # s without an answer


class PublishedFile(NamedTuple):
    """A published file: its path in the authors' repository and the SHA-256 of its bytes."""

    path: str
    sha256: str

    @property
    def name(self) -> str:
        """The last part of the path, unique among the files."""
        return self.path.rpartition("/")[2]


@cache
def registry() -> dict[str, PublishedFile]:
    """Return the published files by name, the eleven small ones without noise first."""
    lines = Path(__file__).with_name("registry.txt").read_text(encoding="utf-8").splitlines()
    published = [
        PublishedFile(path, sha256) for sha256, _, path in (line.partition("  ") for line in lines if line[0] != "#")
    ]
    return {file.name: file for file in sorted(published, key=lambda file: "/" in file.path)}


def data_folder() -> Path:
    """Return the folder with the published recordings: ``$BENCH_PUBLISHED_DATA``, or one among the user's data."""
    return Path(os.environ.get(VARIABLE) or Path(user_data_dir("backlash-bench")) / "published")


def look_up(file: PublishedFile, folder: Path) -> tuple[Path | None, bool]:
    """Return the path of a file in a folder or below it, None if it is missing, and whether its content is right.

    Raises:
        BenchError: for a file that cannot be read.
    """
    damaged = None
    for search in (folder.glob, folder.rglob):  # those of a clone lie deeper
        for path in filter(Path.is_file, sorted(search(file.name))):
            try:
                digest = hashlib.sha256(path.read_bytes()).hexdigest()
            except OSError as error:
                raise BenchError(f"{path} cannot be read: {error.strerror}") from error
            if digest == file.sha256:
                return path, True
            damaged = damaged or path
    return damaged, False


def require(name: str) -> Path:
    """Return the path of a published file; raises BenchError if it is missing or differs."""
    folder = data_folder()
    path, whole = look_up(registry()[name], folder)
    if path is None:
        raise BenchError(f"the published recording {name} is not in {folder}; get it with 'bench data fetch'")
    if not whole:
        raise BenchError(
            f"{path} is not the published recording, as its SHA-256 differs; get it anew with 'bench data fetch'"
        )
    return path


def download(
    published: Mapping[str, PublishedFile], to: Path, base_url: str, *, on_file: Callable[[str], None] = lambda _: None
) -> None:
    """Download the files that a folder lacks from below a URL; each file is checked before it takes its name.

    Raises:
        BenchError: for a connection that fails, a file that is not the published one, and a folder that cannot be
            written; the files that came before it stay.
    """
    import pooch  # slow to import, and only this command needs it

    pooch.get_logger().setLevel("WARNING")
    urls = {name: base_url + quote(file.path) for name, file in published.items()}
    hashes = {name: f"sha256:{file.sha256}" for name, file in published.items()}
    store = pooch.create(path=to, base_url=base_url, registry=hashes, urls=urls)
    downloader = pooch.HTTPDownloader(timeout=TIMEOUT, chunk_size=2**16)
    for name, file in published.items():
        if look_up(file, to)[1]:
            continue
        try:
            store.fetch(name, downloader=downloader)
        except ValueError as error:
            raise BenchError(
                f"{urls[name]} is not the published file, as its SHA-256 differs; try again, or set {VARIABLE} to "
                "a clone of the repository"
            ) from error
        except OSError as error:  # the errors of requests are OSErrors, too
            if not hasattr(error, "response"):
                raise BenchError(f"{to / name} cannot be written: {error.strerror or 'permission denied'}") from error
            answer = error.response
            why = "the connection failed" if answer is None else f"the server answers {answer.status_code}"
            raise BenchError(
                f"{name} cannot be downloaded from {urlsplit(base_url).netloc}: {why}; try again, which goes on from "
                f"here, or set {VARIABLE} to a clone of the repository"
            ) from error
        on_file(name)
