import pytest

from bench.helpers.errors import BenchError
from bench.study.budget import Budget


@pytest.mark.parametrize(
    ("given", "held", "at_10", "words"),
    [
        (500, 500, 500, "500 evaluations"),
        (1, 1, 1, "1 evaluation"),
        ("60_000", 60_000, 60_000, "60,000 evaluations"),
        ("1e4 * d", "1e4 * d", 100_000, "10,000 d evaluations"),
        (" 2.5*d ", "2.5*d", 25, "2.5 d evaluations"),
        ("0.01 * d", "0.01 * d", 1, "0.01 d evaluations"),
        ({"10": 200_000, "20": 1_000_000}, {"10": 200_000, "20": 1_000_000}, 200_000,
         "200,000 evaluations at d = 10 and 1,000,000 evaluations at d = 20"),
    ],
)  # fmt: skip
def test_a_budget_is_a_number_a_multiple_of_d_or_a_table(given, held, at_10, words):
    budget = Budget.read(given, "the budget")
    assert (budget.plain, budget.evaluations(10), budget.words) == (held, at_10, words)
    assert Budget.read(held, "the budget") == budget == held
    assert budget.number == (held if isinstance(held, int) else None)


@pytest.mark.parametrize(
    "given",
    [0, -5, 2.5, True, None, "", "d", "1e4", "1e4 d", "d * 1e4", "1e4 * d * d", "0 * d", "-1 * d", "1e99 * d",
     "nan * d", "__import__('os')", [1], {}, {"ten": 5}, {"0": 5}, {"10": 0}, {"10": "1e4"},
     10**30, "1__0", "5_", "1" + "0" * 30, "9" * 5000, {"10": 10**30}],
)  # fmt: skip
def test_anything_else_is_refused_in_a_sentence(given):
    with pytest.raises(BenchError, match=r"^the budget"):
        Budget.read(given, "the budget")
