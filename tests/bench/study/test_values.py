"""The fields and values of a study: what they take, hold, equal and show."""

import dataclasses
import pickle
from dataclasses import dataclass

import pytest

from bench import BenchError
from bench.study.rope import Rope
from bench.study.values import Checked


@dataclass(frozen=True)
class Holder:
    rope: Checked[Rope | None] = Checked(Rope.read)


def test_a_field_holds_what_its_reader_returns():
    holder = Holder("1 %")
    assert holder.rope == Rope("1%")
    assert dataclasses.replace(holder) == holder == pickle.loads(pickle.dumps(holder))
    assert dataclasses.replace(holder, rope=2) == Holder(Rope(2.0))
    assert Holder().rope is None


def test_a_field_refuses_by_name_what_its_reader_refuses():
    with pytest.raises(BenchError, match=r"^'rope' must be a positive width"):
        Holder("wide")
    with pytest.raises(dataclasses.FrozenInstanceError):
        Holder().rope = 1.0


def test_a_value_equals_and_shows_the_plain_value():
    ropes = {Rope.read(given, "the rope") for given in ("1%", 0.5, "0.5")}
    assert ropes == {"1%", 0.5}
    assert repr(Holder(0.5)) == "Holder(rope=0.5)"
