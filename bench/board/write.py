"""Write the board of several archives: index.html, board.csv, and a page for each study."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from bench.board import pages
from bench.board.again import make_again
from bench.board.archive import Archive, read, refuse_twins
from bench.board.ranks import SettingRanks, standings
from bench.errors import BenchError
from bench.helpers.atomic import names_in, replacing
from bench.helpers.console import OnStep
from bench.helpers.text import file_name
from bench.sandbox import bubblewrap

PAGE, TABLE, STUDIES = "index.html", "board.csv", "studies"


@dataclass(frozen=True)
class Board:
    """A board that was written: its first page, the archives on it, and why others were left out."""

    page: Path
    archives: tuple[Archive, ...]
    refused: tuple[str, ...]


def write_board(
    sources: Sequence[Path],
    output: Path,
    *,
    verify: int = 0,
    keep_going: bool = False,
    on_progress: OnStep = lambda *_: None,
) -> Board:
    """Write a static site over archives that :func:`bench.formats.archive.pack` wrote.

    Each archive is unpacked and verified. The same archives give the same bytes, in any order. Nothing is written where
    one is refused, unless others are to be written without it.

    Args:
        sources: the archives.
        output: the folder to write: a new or empty one, or that of an earlier board, which is replaced.
        verify: trials of each archive to make again, in a sandbox.
        keep_going: leave out archives that are refused, and write the rest.
        on_progress: called with the name of each archive, the number of archives read, and of all.

    Raises:
        BenchError: for an archive that is refused, an output that cannot be written, and ``verify`` without a sandbox.
    """
    _refuse_others(output)
    if verify:
        bubblewrap.find()  # before any archive is read
    read_archives: list[Archive] = []
    refused = []
    for place, source in enumerate(sorted(sources, key=lambda path: (path.name, str(path)))):
        on_progress(source.name, place, len(sources))
        try:
            read_archives.append(_read(source, read_archives, verify))
        except BenchError as error:
            if not keep_going:
                raise
            refused.append(str(error))
    if not read_archives:
        raise BenchError(refused[0] if refused else "a board needs an archive that 'bench pack' wrote")
    _write(read_archives, output)
    return Board(output / PAGE, tuple(read_archives), tuple(refused))


def _refuse_others(output: Path) -> None:
    """Raise BenchError for a folder that holds anything but a board."""
    present = names_in(output)
    if present and not (TABLE in present and present <= {PAGE, TABLE, STUDIES}):
        raise BenchError(f"{output} holds other files than a board; give a new folder by --output")


def _read(source: Path, earlier: Sequence[Archive], verify: int) -> Archive:
    with tempfile.TemporaryDirectory(prefix="bench-board-") as temporary:
        path = Path(temporary) / "study"
        archive = read(source, path)
        refuse_twins([*earlier, archive])
        return replace(archive, again=make_again(path, verify, archive.sha256)) if verify else archive


def _write(archives: Sequence[Archive], output: Path) -> None:
    settings = standings(archives)
    # A name that differs from another one in capitals alone is refused, so that no two pages share a file.
    addresses = {archive.name: f"{STUDIES}/{file_name(archive.name.lower())}.html" for archive in archives}
    with replacing(output.resolve()) as temporary:
        (temporary / STUDIES).mkdir(parents=True)
        pages.write_index(temporary / PAGE, archives, settings, addresses)
        for archive in archives:
            pages.write_study(temporary / addresses[archive.name], archive)
        tables = [_flat(number, standing) for number, standing in enumerate(settings, start=1)]
        pd.concat(tables).to_csv(temporary / TABLE, index=False, lineterminator="\n")


def _flat(number: int, standing: SettingRanks) -> pd.DataFrame:
    """Return the rows of a standing behind the number of its table and its setting."""
    setting = standing.setting
    shared = {
        "table": number, "suite": setting.suite, "dimension": setting.dimension, "budget": setting.budget,
        "problems": len(setting.problems), "constraints": setting.constraints,
        "looks": " ".join(map(str, setting.looks)),
    }  # fmt: skip
    plain = standing.rows.rename(columns=lambda name: name.lower().replace(" ", "_").replace("-", ""))
    return pd.DataFrame([shared] * len(plain)).join(plain)
