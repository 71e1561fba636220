"""The folders that the tests of stores read."""

from tests.bench.storage.conftest import filled, spoilt

__all__ = ["filled", "spoilt"]
