"""Change a store as other programs do, and as code does that imports this package."""

import sqlite3
from contextlib import closing

from bench.storage.committed import Committed
from bench.storage.reading import READ, Reader
from bench.storage.rows import binding, digest

EARLY = "(SELECT cell FROM selected WHERE problem = 'sphere-2' AND optimizer = 'early')"
SCATTER = "(SELECT cell FROM selected WHERE problem = 'sphere-2' AND optimizer = 'scatter')"


def change(path, *statements):
    """Run SQL statements on a store, as any program can."""
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def forge(path, *statements):
    """Run SQL statements on a store, and give all rows digests that fit, as only this package's code can."""
    change(path, *statements)
    with closing(sqlite3.connect(path)) as connection, connection:
        reader = Reader(connection, Committed())
        for _, cell, names, trial, *values in connection.execute(f"SELECT {', '.join(READ)} FROM results").fetchall():
            bound = binding(reader.cells.all[cell], reader.names.get(names, (None, None)))
            written = digest(bound, (trial, *values)), cell, trial
            connection.execute("UPDATE results SET digest = ? WHERE cell = ? AND trial = ?", written)
