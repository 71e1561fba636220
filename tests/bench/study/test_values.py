"""The fields and values of a study: what they take, hold, equal and show."""

import dataclasses
import pickle
from dataclasses import dataclass

import pytest

from bench import BenchError
from bench.study.budget import Budget
from bench.study.values import Checked


@dataclass(frozen=True)
class Holder:
    budget: Checked[Budget | None] = Checked(Budget.read)


def test_a_field_holds_what_its_reader_returns():
    holder = Holder("100 * d")
    assert holder.budget == Budget.read("100 * d")
    assert dataclasses.replace(holder) == holder == pickle.loads(pickle.dumps(holder))
    assert dataclasses.replace(holder, budget=2) == Holder(Budget.read(2))
    assert Holder().budget is None


def test_a_field_refuses_by_name_what_its_reader_refuses():
    with pytest.raises(BenchError, match=r"^'budget'"):
        Holder("wide")
    with pytest.raises(dataclasses.FrozenInstanceError):
        Holder().budget = 1


def test_a_value_equals_and_shows_the_plain_value():
    budgets = {Budget.read(given) for given in ("100 * d", 50, "50")}
    assert budgets == {"100 * d", 50}
    assert repr(Holder(50)) == "Holder(budget=50)"
