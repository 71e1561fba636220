"""Export the results of a study in the formats of other tools."""

from __future__ import annotations

import shutil
from pathlib import Path

from bench.formats import EXPORTABLE, FORMATS
from bench.formats.trials import omission_notes
from bench.helpers.errors import BenchError, nearest, reason
from bench.results.results import StoredResults

README = "README.txt"


def export(results: StoredResults, kind: str, folder: Path) -> list[str]:
    """Write the results into ``folder`` in one of ``bench.formats.EXPORTABLE``; the same results give the same bytes.

    An earlier export of the same format is replaced as a whole. Returns sentences on what the format could not
    hold, which the folder's README has too.

    Raises:
        BenchError: for an unknown format, for a study without trials or one that the format cannot hold, and for a
            folder that cannot be written or holds anything else.
    """
    if kind not in EXPORTABLE:
        raise BenchError(f"unknown export format {kind!r}{nearest(kind, EXPORTABLE)}")
    if results.frame.empty:
        raise BenchError(f"{results.paths[0]} holds no trials yet; run the study first")
    chosen = FORMATS[kind].writer
    files = chosen.files(results)
    notes = [] if chosen.holds_failures else omission_notes(results.frame)
    title = f"An export in the format {kind}. The next export into this folder replaces everything in it."
    readme = f"{title}\n\nStudy: {results.study.title or results.study.name}\n\n{chosen.about(results)}"
    try:
        _empty(folder, title)
        _write(folder / README, "\n".join([readme, *notes, ""] if notes else [readme]))
        _write(folder / "study.toml", results.study.to_toml())
        for path, content in files:
            _write(folder / path, content)
    except OSError as error:
        raise BenchError(f"the export cannot be written into {folder}: {reason(error)}") from error
    return notes


def _empty(folder: Path, title: str) -> None:
    """Remove an earlier export, but not the folder, which may be a mount or where the user is.

    Raises:
        BenchError: when it holds anything else.
    """
    content = list(folder.iterdir()) if folder.exists() else []
    readme = folder / README
    if content and not (readme.is_file() and readme.read_bytes().startswith(title.encode())):
        raise BenchError(f"{folder} holds something other than an earlier export of this format; give another folder")
    for path in content:
        shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def _write(path: Path, content: str | bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
