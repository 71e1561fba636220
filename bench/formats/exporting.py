"""Export the results of a study in the formats of other tools."""

from __future__ import annotations

from pathlib import Path

from bench.errors import BenchError, nearest
from bench.formats import EXPORTABLE, FORMATS
from bench.formats.trials import omission_notes
from bench.helpers.atomic import replacing
from bench.helpers.text import listed
from bench.storage.results import Results

README = "README.txt"


def export(results: Results, kind: str, folder: Path) -> list[str]:
    """Write the results into ``folder`` in one of ``bench.formats.EXPORTABLE``; the same results give the same bytes.

    An earlier export of the same format is replaced as a whole. Returns sentences on damaged trials and on what the
    format could not hold, which the folder's README has too.

    Raises:
        BenchError: for an unknown format, for a study without trials or one that the format cannot hold, and for a
            folder that cannot be written or holds anything else.
    """
    if kind not in EXPORTABLE:
        raise BenchError(f"unknown export format {kind!r}{nearest(kind, EXPORTABLE)}")
    if results.frame.empty:
        raise BenchError("; ".join(results.damage) or f"{results.paths[0]} holds no trials yet; run the study first")
    chosen = FORMATS[kind].writer
    files = chosen.files(results)
    notes = results.damage + _controls(results) + ([] if chosen.holds_failures else omission_notes(results.frame))
    title = f"An export in the format {kind}. The next export into this folder replaces everything in it."
    readme = f"{title}\n\nStudy: {results.study.title or results.study.name}\n\n{chosen.about(results)}"
    _refuse_other(folder, title)
    with replacing(folder) as temporary:
        _write(temporary / README, "\n".join([readme, *notes, ""] if notes else [readme]))
        _write(temporary / "study.toml", results.study.to_toml())
        for path, content in files:
            _write(temporary / path, content)
    return notes


def _controls(results: Results) -> list[str]:
    """Return the sentence on the trials of controls, which are in no export; none without any."""
    left = len(results.controls)
    names = listed([entry.label for entry in results.study.controls])
    return [f"Left out, because controls are not compared with the optimizers: {left:,} trials of {names}."] * bool(
        left
    )


def _refuse_other(folder: Path, title: str) -> None:
    """Raise BenchError when a folder holds anything but an earlier export."""
    readme = folder / README
    content = folder.is_dir() and any(folder.iterdir())
    if content and not (readme.is_file() and readme.read_bytes().startswith(title.encode())):
        raise BenchError(f"{folder} holds something other than an earlier export of this format; give another folder")


def _write(path: Path, content: str | bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
