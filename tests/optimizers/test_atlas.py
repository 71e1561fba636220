"""The table of methods that several optimizers implement."""

import pytest

from bench import load_optimizer
from bench.atlas import methods
from optimizers import atlas

METHODS = methods()


def test_the_installed_table_is_that_of_the_built_in_optimizers():
    assert {each.name for each in METHODS} >= {"gwo", "alo", "goa", "da", "de-rand-1-bin", "pso", "cma-es", "l-shade"}
    assert atlas.name == "atlas.toml"


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_implementation_can_be_made_with_its_options(method):
    for each in method.implementations:
        load_optimizer(each.name, **each.options)
        assert bool(each.source) <= bool(each.differs)
