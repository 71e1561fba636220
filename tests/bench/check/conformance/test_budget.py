"""The rules of the budget."""

import pytest

from tests.bench.check import faulty
from tests.bench.check.conformance.examine import expect_broken

FAULTS = [
    (faulty.Broken, "run", "it raised ZeroDivisionError: by zero", "mend what raises"),
    (faulty.Idle, "run", "without a single evaluation", "ask objective(x)"),
    (faulty.Stubborn, "budget", "2 more times after the budget of 1 was spent", "let BudgetExhausted pass"),
    (faulty.Rounding, "budget", "without a single evaluation of a budget of 1", "below one generation"),
]


@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "mend"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, mend):
    expect_broken(optimizer, rule, finding, mend)
