"""Pack a study's folder into one verified archive, and unpack such an archive.

An archive is a zip file whose root is an RO-Crate 1.1: the payload (``contents``), its description in
``ro-crate-metadata.json`` (``crate``), and the SHA-256 of every file in ``SHA256SUMS``.
"""

from bench.formats.archive.pack import Packed, pack
from bench.formats.archive.unpack import Unpacked, unpack

__all__ = ["Packed", "Unpacked", "pack", "unpack"]
