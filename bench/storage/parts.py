"""Read a large store in several processes, each of which reads, compares and packs one part of its trials."""

from __future__ import annotations

import json
import pickle
import sqlite3
import subprocess
import sys
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from itertools import chain, zip_longest
from typing import TYPE_CHECKING

from bench.storage.reading import Reader, StoreCheck, Tally

if TYPE_CHECKING:
    from bench.storage.blocks import Block

_START = """
import json, sys
sys.path[:], *given = json.loads(sys.argv.pop())
from bench.storage.parts import main
main(*given)
"""


class LostPartError(Exception):
    """A process that read a part of a store has ended before it had read all of it."""


def read_parts(reader: Reader, skipped: Collection[str], parts: int) -> Iterator[Block | StoreCheck]:
    """Yield the sound trials of a store, and at last the outcome of comparing all of them with their digests.

    Args:
        reader: the store, opened by this process.
        skipped: problems whose trials are compared, but not yielded.
        parts: the number of processes, this one included.

    Raises:
        LostPartError: where another process ended too early; this one alone may succeed, or raise what that one met.
        sqlite3.Error: where a part of the rows cannot be read.
        BenchError: where a text is no JSON, in a store of the layout without digests.
    """
    tallies = []
    with ExitStack() as started:
        others = [started.enter_context(_process(reader.uri, skipped, part, parts)) for part in range(1, parts)]
        for other in others:
            started.callback(other.kill)
        in_turns = zip_longest(reader.blocks(skipped, 0, parts), *map(_received, others))
        for each in filter(None, chain.from_iterable(in_turns)):
            if isinstance(each, Tally):
                tallies.append(each)
            else:
                yield each
    yield reader.outcome(tallies)


def _process(uri: str, skipped: Collection[str], part: int, parts: int) -> subprocess.Popen[bytes]:
    given = json.dumps([[str(each) for each in sys.path], uri, [*skipped], part, parts])
    command = [sys.executable, "-c", _START, given]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)


def _received(process: subprocess.Popen[bytes]) -> Iterator[Block | Tally]:
    """Yield what the process writes, up to its tally."""
    each: Block | Tally | None = None
    while not isinstance(each, Tally):
        try:
            each = pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except (EOFError, pickle.UnpicklingError):
            raise LostPartError from None
        yield each


def main(uri: str, skipped: list[str], part: int, parts: int) -> None:
    """Read one part of a store, as :func:`read_parts` asks in another process, and write it to standard output."""
    reader = Reader(sqlite3.connect(uri, timeout=30, uri=True), uri)
    for each in reader.blocks(skipped, part, parts):
        pickle.dump(each, sys.stdout.buffer, pickle.HIGHEST_PROTOCOL)
        sys.stdout.flush()
