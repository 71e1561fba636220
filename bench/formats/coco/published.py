"""COCO's data archive: the published results of others, by name, checked against the archive's own list of hashes.

The archive lists the path, SHA-256 and size of every data set of a suite. Both the list and the sets are kept in the
user's data folder, so that each is downloaded once; ``source`` names a folder to take them from instead.

Source: https://numbbo.github.io/data-archive (Hansen et al. 2021, Optimization Methods and Software 36(1)).
"""

from __future__ import annotations

import ast
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from urllib.parse import quote

from platformdirs import user_data_dir

from bench.formats.importing import import_results
from bench.formats.source import sha256_of
from bench.helpers.errors import BenchError, nearest
from bench.storage import provenance

VARIABLE = "BENCH_ARCHIVE"
BASE_URL = "https://numbbo.github.io/data-archive/data-archive/"
DEFINITION = "coco_archive_definition.txt"
SUITES = ("bbob", "bbob-constrained", "bbob-largescale", "bbob-mixint", "bbob-noisy")
"""The suites of the archive whose problems have one objective."""

TIMEOUT = 30  # s without an answer
LARGEST = 10_000_000  # bytes of a list
_SHOWN = 6


class DataSet(NamedTuple):
    """A published data set: its suite, its path in the archive, the SHA-256 of its bytes, and its size in kB."""

    suite: str
    path: str
    sha256: str
    kilobytes: float

    @property
    def name(self) -> str:
        """The name that selects it, such as ``bbob/2009/BIPOP-CMA-ES_hansen_noiseless``."""
        return f"{self.suite}/{_stem(self.path)}"

    @property
    def algorithm(self) -> str:
        """The algorithm, the first part of the file's name."""
        return PurePosixPath(_stem(self.path)).name.partition("_")[0]

    @property
    def names(self) -> tuple[str, str, str]:
        """Its names after the suite: path, algorithm, or year and algorithm, as in ``2009/DIRECT``."""
        return _stem(self.path), self.algorithm, f"{PurePosixPath(self.path).parent}/{self.algorithm}"


def data_folder() -> Path:
    """Return the folder that keeps data sets: ``$BENCH_ARCHIVE``, or one among the user's data."""
    return Path(os.environ.get(VARIABLE) or Path(user_data_dir("backlash-bench")) / "archive")


def data_sets(suite: str, source: Path | None = None) -> list[DataSet]:
    """Return the data sets of a suite, from the kept list, from one in ``source``, or downloaded.

    Raises:
        BenchError: for an unknown suite, a list that cannot be read or downloaded, and a ``source`` without one.
    """
    if suite.startswith("bbob-biobj"):
        raise BenchError(f"{suite} has several objectives; bi-objective results are not supported")
    if suite not in SUITES:
        raise BenchError(f"the archive has no suite {suite!r}{nearest(suite, SUITES)}")
    file = None if source is None else _definition_in(source, suite)
    kept = _keep(f"{suite}/{DEFINITION}", None if file is None else sha256_of(file), file)
    try:
        if kept.stat().st_size > LARGEST:
            raise ValueError("it is too large")
        rows = [row for row in ast.literal_eval(kept.read_text(encoding="utf-8")) if len(row) == 3]
        return [DataSet(suite, *_row_of_list(*row)) for row in rows]
    except (OSError, ValueError, SyntaxError, TypeError, MemoryError, RecursionError) as error:
        raise BenchError(f"{kept} is no list of an archive ({error}); remove it to get it anew") from error


def find(name: str, source: Path | None = None) -> DataSet:
    """Return the data set of a name such as ``bbob/BIPOP-CMA-ES`` or ``bbob/2009/BIPOP-CMA-ES_hansen_noiseless``.

    Raises:
        BenchError: where none has that name, or several have.
    """
    suite, _, within = name.partition("/")
    if not within:
        raise BenchError(f"{name!r} is no name of a published data set, such as 'bbob/BIPOP-CMA-ES'")
    sets = data_sets(suite, source)
    by_form = ([data for data in sets if data.names[form].lower() == _stem(within).lower()] for form in range(3))
    matches = next(filter(None, by_form), [])
    if len(matches) > 1:
        shown = ", ".join(data.name for data in matches[:_SHOWN])
        raise BenchError(f"{name!r} stands for {len(matches)} data sets; give one of {shown}")
    if matches:
        return matches[0]
    raise BenchError(f"the archive has no {name!r}{nearest(name, {f'{suite}/{data.algorithm}' for data in sets})}")


def fetch(name: str, source: Path | None = None) -> Path:
    """Return the file of a data set, which is copied from ``source``, or downloaded where it is not kept yet.

    Raises:
        BenchError: as :func:`find`, and for a file that is missing, cannot be downloaded, or has another SHA-256.
    """
    chosen = find(name, source)
    kept = data_folder() / chosen.suite / chosen.path
    if kept.is_file() and sha256_of(kept) == chosen.sha256:
        return kept
    found = (file for file in _candidates(source, chosen) if sha256_of(file) == chosen.sha256) if source else ()
    file = next(iter(found), None)
    if source is not None and file is None:
        raise BenchError(f"{source} has no file with the SHA-256 of {chosen.name}, {chosen.sha256[:12]}…")
    return _keep(f"{chosen.suite}/{chosen.path}", chosen.sha256, file)


def imported(name: str, source: Path | None = None) -> Path:
    """Return the folder of an imported data set, which is fetched and imported where it is not kept yet.

    Raises:
        BenchError: as :func:`fetch`, and as :func:`bench.formats.importing.import_results`.
    """
    chosen = find(name, source)
    version = hashlib.sha256(provenance.package().encode()).hexdigest()[:8]  # another version may read it otherwise
    folder = data_folder() / "imported" / f"{chosen.sha256[:12]}-{version}" / chosen.algorithm
    if not (folder / "study.toml").exists():
        import_results(fetch(name, source), folder, name=chosen.name)
    return folder


def _stem(path: str) -> str:
    return re.sub(r"\.(tgz|tar\.gz|tar|zip)$", "", path, flags=re.IGNORECASE)


def _row_of_list(path: object, sha256: object, kilobytes: object) -> tuple[str, str, float]:
    """Return a row of the list; raises ValueError for one that is none."""
    parts = PurePosixPath(str(path)).parts
    if not parts or ".." in parts or PurePosixPath(str(path)).is_absolute() or "\\" in str(path):
        raise ValueError(f"the path {path!r}")
    if not re.fullmatch(r"[0-9a-f]{64}", str(sha256)):
        raise ValueError(f"the SHA-256 {sha256!r}")
    return str(path), str(sha256), float(str(kilobytes))


def _definition_in(source: Path, suite: str) -> Path:
    for file in (source / suite / DEFINITION, source / DEFINITION, *sorted(source.glob(f"*{suite}*definition*.txt"))):
        if file.is_file():
            return file
    raise BenchError(f"{source} has no list of the archive's data sets, {suite}/{DEFINITION}")


def _candidates(source: Path, chosen: DataSet) -> Iterator[Path]:
    """Yield the files of a folder that may be a data set: those at its path, then all archives."""
    yield from filter(Path.is_file, (source / chosen.suite / chosen.path, source / chosen.path))
    yield from (file for file in sorted(source.rglob("*")) if file.is_file() and _stem(file.name) != file.name)


def _keep(path: str, sha256: str | None, file: Path | None) -> Path:
    """Return a kept file of the archive, copied from ``file`` or downloaded unless it is there with the SHA-256."""
    import pooch  # slow to import, and only what is not kept yet needs it

    pooch.get_logger().setLevel("WARNING")
    download = pooch.HTTPDownloader(timeout=TIMEOUT, chunk_size=2**16)
    get = download if file is None else lambda _, output, __: shutil.copyfile(file, output)
    checksum = None if sha256 is None else f"sha256:{sha256}"
    kept = data_folder() / path
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        pooch.retrieve(BASE_URL + quote(path), checksum, fname=kept.name, path=kept.parent, downloader=get)
    except ValueError as error:
        raise BenchError(f"{BASE_URL}{path} has another SHA-256 than the archive's list; try again later") from error
    except OSError as error:  # the errors of requests are OSErrors, too
        if not hasattr(error, "response"):
            raise BenchError(f"{kept} cannot be written: {error.strerror or error}") from error
        why = "the connection failed" if error.response is None else f"the server answers {error.response.status_code}"
        raise BenchError(
            f"{BASE_URL}{path} cannot be downloaded: {why}; 'bench import --from FOLDER' takes it from a folder"
        ) from error
    return kept
