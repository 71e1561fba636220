"""Notice that a stored trial was changed: a keyed digest binds a row's identity, all its columns and its trace.

The digest is a BLAKE2b hash that begins with the key of the trial's cell, which is a hash of the store's own key (16
random bytes in the store) and of the labels of problem and optimizer. So a row whose bytes changed, that was edited by
a program other than this package, that was moved to another trial or cell, or whose cell has another label, no longer
fits its digest. The key is no secret from code that runs as the same user and imports this package: that can write
digests which fit. Only a sandbox keeps it from the store, and only making the trial again shows it.

This module imports nothing but the standard library, and is also run as a script: SQLite hands over rows so slowly that
a large store is checked by several processes.
"""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from hashlib import blake2b
from marshal import dumps
from typing import Any, NamedTuple

MEASURED = (
    "environment", "seed", "status", "fun", "nfev", "wall_s", "cpu_s", "objective_s", "stop", "outside_box", "error",
    "x", "figures",
)  # fmt: skip
"""The columns of a trial beside its key and its trace."""

FORMAT = 2  # of marshal: the last one in which equal values have equal bytes; tests hold these bytes
LARGE = 32_000_000  # bytes of a store from which on several processes are faster
MOST = 8  # processes

TEXTS = ("status", "stop", "error")
JSON = ("x", "figures")
"""Those of the measured columns that hold plain texts, and JSON texts; the others hold numbers."""

_TEXTS = (*TEXTS, *JSON)
_NUMBERS = ("cell", "trial", *(name for name in MEASURED if name not in _TEXTS))

# Damage may leave texts that are no UTF-8, or texts where numbers belong, which SQLite could not hand over: texts go as
# bytes, and only rows whose columns hold the types that they were written with are handed over at all.
_TYPED = " AND ".join(
    [f"({name} < x'') IS NOT 0" for name in _TEXTS]
    + [f"(+{name} < '') IS NOT 0" for name in _NUMBERS]
    + ["(trace >= x'') IS NOT 0"]
)
COLUMNS = ", ".join(["cell, trial", *(f"CAST({name} AS BLOB)" if name in _TEXTS else name for name in MEASURED)])
"""The SQL columns of a row: its key, and those measured, texts as UTF-8."""

COMPARED = f"CAST(digest AS BLOB), {COLUMNS}, trace"
"""The SQL columns that :attr:`Digests.sound` compares; texts are UTF-8."""

_NOT_TYPED = "sound(NULL, CAST(cell AS INTEGER), CAST(trial AS INTEGER))"

TYPED = f"CASE WHEN {_TYPED} THEN 1 ELSE {_NOT_TYPED} END"
"""The SQL condition that a row of ``TRIALS`` can be compared, on a connection with :class:`Digests`."""

SOUND = f"CASE WHEN {_TYPED} THEN sound({COMPARED}) ELSE {_NOT_TYPED} END"
"""The SQL condition that a row of ``TRIALS`` fits its digest, likewise."""

SEAL = (
    f"UPDATE results SET digest = row_digest({COLUMNS},"
    " (SELECT trace FROM traces WHERE traces.cell = results.cell AND traces.trial = results.trial))"
)
"""The SQL statement that gives rows their digests, on a connection with :class:`Digests`."""

TRIALS = "results LEFT JOIN traces USING (cell, trial)"

INTERRUPTED = "user-defined function raised exception"
"""The message in which SQLite hides a KeyboardInterrupt that one of the functions met; they raise nothing else."""

Place = tuple[int, int]
"""Number of the cell, and of the trial; -1 stands for anything but a whole number."""


def new_key() -> tuple[bytes, bytes]:
    """Return a random key and its own digest, by which damage of the key is not mistaken for damage of every row."""
    key = os.urandom(16)
    return key, _hash(key)


def _hash(content: bytes, size: int = 8) -> bytes:
    return blake2b(content, digest_size=size).digest()


def shares(connection: sqlite3.Connection) -> int:
    """Return the number of processes among which the rows of a store are divided."""
    pages, size = (connection.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_count", "page_size"))
    if pages * size < LARGE or not sys.executable:
        return 1
    affinity = getattr(os, "sched_getaffinity", None)
    return min(MOST, len(affinity(0)) if affinity else os.cpu_count() or 1)


def share(part: int, parts: int) -> str:
    """Return the SQL condition that a row belongs to one part of a store.

    Every part looks at all rows and takes those whose cell and trial, added and divided by ``parts``, leave ``part``:
    of parts that begin and end at a key, two could miss a row whose key was damaged.
    """
    return f"coalesce(abs((cell + trial) % {parts}), 0) = {part}" if parts > 1 else "1"


class Counts(NamedTuple):
    """The number of sound rows, of those that have a trace, and the largest number of an environment they refer to."""

    rows: int
    traces: int
    environment: int


class Digests:
    """The digests of one store, as the SQL functions of ``SOUND`` and ``SEAL`` on an open connection.

    Attributes:
        labels: problem and optimizer of each cell, by its number.
        sound: whether a row fits its digest, given the values of ``COMPARED``.

    Raises:
        sqlite3.DatabaseError: where the store's key is damaged.
    """

    def __init__(self, connection: sqlite3.Connection) -> None:
        self.labels: dict[object, tuple[str, str]] = {}
        self._connection = connection
        self._damaged: list[Place] = []
        self._keys: dict[object, bytes] = {}
        stored = connection.execute("SELECT CAST(key AS BLOB), CAST(digest AS BLOB) FROM digest_key").fetchall()
        if len(stored) != 1 or stored[0][0] is None or _hash(stored[0][0]) != stored[0][1]:
            raise sqlite3.DatabaseError("the key of its digests is damaged")
        self._key: bytes = stored[0][0]
        for cell, *labels in connection.execute(
            "SELECT id, CAST(problem AS BLOB), CAST(optimizer AS BLOB) FROM cells"
            " WHERE typeof(problem) = 'text' AND typeof(optimizer) = 'text'"
        ):
            problem, optimizer = (label.decode(errors="replace") for label in labels)
            self.add(cell, problem, optimizer)
        self.sound = _sound(self._keys, self._damaged)
        connection.create_function("sound", -1, self.sound)
        connection.create_function("row_digest", -1, _row_digest(self._keys))

    def add(self, cell: int, problem: str, optimizer: str) -> None:
        """Add a cell, whose rows can be given digests from now on."""
        self.labels[cell] = problem, optimizer
        self._keys[cell] = _hash(self._key + dumps((problem, optimizer), FORMAT), 16)

    def record(self, number: int, record: bytes | None) -> bytes:
        """Return the digest of an environment's record, whose JSON text is given as UTF-8."""
        return _hash(self._key + dumps((number, record), FORMAT))

    def count(self, part: int, parts: int) -> Counts:
        """Count the rows of one part of the store that fit their digests; :meth:`take` returns the others."""
        rows = f"{TRIALS} WHERE {share(part, parts)} AND {SOUND}"
        query = f"SELECT count(*), count(trace), coalesce(max(environment), 0) FROM {rows}"
        return Counts(*self._connection.execute(query).fetchone())

    def take(self) -> list[Place]:
        """Return the rows read since the last call that do not fit their digests."""
        damaged = self._damaged.copy()
        self._damaged.clear()
        return damaged

    def check(self, uri: str) -> Counts:
        """Count the rows of the whole store that fit their digests; :meth:`take` returns the others.

        Further processes, which open the store by its URI, read a part of a large store each.

        Raises:
            sqlite3.Error: where the store cannot be read.
        """
        parts = shares(self._connection)
        with ExitStack() as started:
            others = [started.enter_context(_process(uri, part, parts)) for part in range(1, parts)]
            for other in others:
                started.callback(other.kill)
            counts = [self.count(0, parts)]
            for part, other in enumerate(others, start=1):
                answer, _ = other.communicate()
                if other.returncode:  # raises here what it met there, or succeeds where it was killed
                    counts.append(self.count(part, parts))
                else:
                    found, damaged = json.loads(answer)
                    counts.append(Counts(*found))
                    self._damaged += [(cell, trial) for cell, trial in damaged]
        rows, traces, environments = zip(*counts, strict=True)
        return Counts(sum(rows), sum(traces), max(environments))


def _process(uri: str, part: int, parts: int) -> subprocess.Popen[bytes]:
    """Start a process that checks one part of a store."""
    command = [sys.executable, "-I", "-S", __file__, uri, str(part), str(parts)]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)


def _sound(keys: dict[object, bytes], damaged: list[Place]) -> Callable[..., int]:
    """Return the function that compares a row with its digest; a million calls take about a second."""

    def sound(digest: object, cell: object, *row: Any) -> int:
        key = keys.get(cell)
        if key is not None and blake2b(key + dumps(row, FORMAT), digest_size=8).digest() == digest:
            return 1
        damaged.append((cell if isinstance(cell, int) else -1, row[0] if isinstance(row[0], int) else -1))
        return 0

    return sound


def _row_digest(keys: dict[object, bytes]) -> Callable[..., bytes | None]:
    """Return the function that gives a row its digest, none to a row of no known cell."""
    return lambda cell, *row: _hash(keys[cell] + dumps(row, FORMAT)) if cell in keys else None


def main() -> None:
    """Check one part of a store, as :meth:`Digests.check` asks in another process, and print the outcome as JSON."""
    uri, part, parts = sys.argv[1:]
    connection = sqlite3.connect(uri, timeout=30, uri=True)
    connection.execute("BEGIN")  # cells and rows of one moment
    digests = Digests(connection)
    print(json.dumps([digests.count(int(part), int(parts)), digests.take()]))


if __name__ == "__main__":
    main()
