"""The rules of robustness."""

import pytest

from tests.bench.check import faulty
from tests.bench.check.conformance.examine import expect_broken

FAULTS = [
    (faulty.Broken, "run", "it raised ZeroDivisionError: by zero", "fix what raises"),
    (faulty.Idle, "run", "without a single evaluation", "ask objective(x)"),
    (faulty.Stubborn, "budget", "2 more times after the budget of 1 was spent", "let BudgetExhausted pass"),
    (faulty.Rounding, "budget", "without a single evaluation of a budget of 1", "below one generation"),
    (
        faulty.Surplus,
        "budget",
        "its first generation has 7 points, one more than its population of 6",
        "as many points",
    ),
    (faulty.Escaping, "box", "lie outside the box, such as [", "clip to objective.lower"),
    (
        faulty.Planar,
        "dimensions",
        "IndexError: index 1 is out of bounds for axis 1 with size 1 in 1 dimension",
        "any dimension",
    ),
    (faulty.Finite, "values", "it raised ValueError: autodetected range of", "+inf can occur"),
    (faulty.Ranging, "values", "points that are not finite with equal values", "guard divisions"),
    (faulty.Content, "values", "returned after 4 of 150 evaluations with equal values", "objective.stop"),
]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "remedy"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, remedy):
    expect_broken(optimizer, rule, finding, remedy)
