"""Change a store as other programs do, and as code does that imports this package."""

import sqlite3
from contextlib import closing

from bench.storage.digests import SEAL, Digests

SCATTER = "(SELECT id FROM cells WHERE problem = 'sphere-2' AND optimizer = 'scatter')"


def change(path, *statements):
    """Run SQL statements on a store, as any program can."""
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def forge(path, *statements):
    """Run SQL statements on a store, and give all rows digests that fit, as only this package's code can."""
    change(path, *statements)
    with closing(sqlite3.connect(path)) as connection, connection:
        Digests(connection)
        connection.execute(SEAL)
