"""Pack a study's folder into one verified archive, and unpack such an archive.

An archive is a zip file of the payload (``contents``) and ``SHA256SUMS``, which has the SHA-256 of every other file.
"""

from bench.formats.archive.pack import Packed, pack
from bench.formats.archive.unpack import Unpacked, unpack

__all__ = ["Packed", "Unpacked", "pack", "unpack"]
