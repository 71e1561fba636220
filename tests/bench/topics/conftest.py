"""Texts that are compared with committed ones."""

import pytest

from tests.bench.topics.page_text import compare


@pytest.fixture
def committed(request):
    """Return a function that compares a text with the committed one of a name, or writes it with ``--update``."""
    return lambda name, text: compare(name, text, request.config.getoption("--update"))
