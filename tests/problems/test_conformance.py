"""Every built-in family keeps the contract of a problem: two of its functions, by the check that anybody can run."""

from importlib.metadata import entry_points

import pytest

from bench.check import check_problem
from bench.helpers.errors import BenchError
from bench.plugins import registry

FOUND = {
    "cec2022-f07-d10": {"variables"},  # x1 and x4 change no value
    "star-discrepancy-sobol-200-d2-i1": {"instances"},  # ioh's Sobol' points of instances 1 and 2 are the same
}
"""What is known and stated where the family is described."""


def members():
    """Yield, of each family of this project, the first name and one from the middle."""
    for entry in sorted(entry_points(group="bench.problems"), key=lambda entry: entry.name):
        if entry.dist.name == registry.DISTRIBUTION:
            grid = registry.grid(entry.name)
            names = [next(grid.names([f])) for f in grid.functions] if grid else entry.load().names()
            yield from dict.fromkeys(names[:: len(names) // 2 or 1][:2])


def checked(name):
    try:
        checkup = check_problem(name)
    except BenchError as error:
        if "bench data fetch" not in str(error):
            raise
        pytest.skip(str(error))
    assert {verdict.check for verdict in checkup if not verdict.passed} == FOUND.get(name, set()), str(checkup)
    assert not checkup.unchecked


@pytest.mark.parametrize("name", ["cec2022-f07-d10", "engineering-gear-train"])
@pytest.mark.slow
def test_some_built_in_problems_keep_the_contract(name):
    checked(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(members()))
def test_two_functions_of_every_built_in_family_keep_the_contract(name):
    checked(name)
