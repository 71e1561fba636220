"""Pack a study's folder into one verified archive, and unpack such an archive.

An archive is a zip file whose root is an RO-Crate 1.1: the payload of :mod:`bench.packing.contents`, its description in
``ro-crate-metadata.json`` (:mod:`bench.packing.crate`), and the SHA-256 of every file in ``SHA256SUMS``.
"""

from bench.packing.pack import Packed, pack
from bench.packing.unpack import Unpacked, unpack

__all__ = ["Packed", "Unpacked", "pack", "unpack"]
