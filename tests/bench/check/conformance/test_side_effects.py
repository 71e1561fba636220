"""The rules of side effects."""

import pytest

from tests.bench.check import faulty
from tests.bench.check.conformance.examine import expect_broken

FAULTS = [
    (faulty.Spying, "contract", "it reads or sets _problem of the objective", ".initial(n)"),
    (faulty.Boasting, "contract", "it reads or sets best_value of the objective", ".initial(n)"),
    (faulty.Stretching, "contract", "it reads or sets upper of the objective", ".initial(n)"),
    (faulty.Chatty, "silence", "such as 'generation ", "print and log nothing"),
    (faulty.Loud, "silence", "such as 'iterating'", "print and log nothing"),
    (faulty.Littering, "leftovers", "1 file in the working folder, such as 'outwalker.log'", "write no files"),
]


@pytest.mark.parametrize(
    ("optimizer", "rule", "finding", "mend"), FAULTS, ids=lambda each: getattr(each, "__name__", "")
)
def test_a_fault_breaks_its_own_rule_alone_and_says_how_to_mend_it(optimizer, rule, finding, mend):
    expect_broken(optimizer, rule, finding, mend)
