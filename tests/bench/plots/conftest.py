"""Every plot is drawn without a warning."""

import pytest

from tests.bench.plots.frames import strict


@pytest.fixture(autouse=True)
def strictly(draws):
    with strict():
        yield
