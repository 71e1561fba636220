"""The anytime traces of a study, held as the bytes that the store holds: a study may have hundreds of thousands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bench.contract.objective import Trace

Key = tuple[str, str, int]
"""Problem label, optimizer label and number of a trial."""


class Traces(Mapping[Key, Trace]):
    """The traces of trials by (problem, optimizer, trial), in the order of the store.

    A trace is unpacked when it is asked for, as objects for all would take several times their bytes.
    """

    def __init__(self, packed: Mapping[Key, bytes]) -> None:
        self.packed = packed

    def __getitem__(self, key: Key) -> Trace:
        return Trace.unpacked(self.packed[key])

    def __iter__(self) -> Iterator[Key]:
        return iter(self.packed)

    def __len__(self) -> int:
        return len(self.packed)
