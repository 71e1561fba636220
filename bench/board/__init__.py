"""A board: a static site over many packed studies, with ranks where results may be compared, and provenance.

Read each archive (:mod:`bench.board.archive`), make some of its trials again (:mod:`bench.board.again`), rank the
optimizers within each setting (:mod:`bench.board.ranks`), and write the pages (:mod:`bench.board.write`).
"""

from bench.board.write import Board, write_board

__all__ = ["Board", "write_board"]
