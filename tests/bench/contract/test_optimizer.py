"""The contract of an optimizer: parameters, the smallest budget, and how an optimizer is built."""

from dataclasses import dataclass
from typing import Literal

import pytest

from bench import BenchError, Optimizer, load_optimizer, parameter
from bench.contract.optimizer import build, is_frozen


@dataclass(frozen=True)
class Sample(Optimizer):
    rate: float = parameter(0.5, minimum=0.0, maximum=1.0)
    mode: Literal["a", "b"] = "a"
    size: int | None = parameter(None, minimum=2)

    def minimize(self, objective, rng):
        """Do nothing."""


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rate": 1.5}, "'rate' of Sample must be from 0.0 to 1.0, not 1.5"),
        ({"rate": float("nan")}, "must be from 0.0 to 1.0, not nan"),
        ({"rate": "x"}, "must be a number"),
        ({"mode": "c"}, "must be one of 'a', 'b'"),
        ({"size": 1}, "must be at least 2, not 1"),
        ({"size": 2.5}, "must be a whole number or nothing"),
    ],
)
def test_parameters_out_of_range_are_named(options, said):
    with pytest.raises(BenchError) as caught:
        Sample(**options)
    assert said in str(caught.value)


def test_the_smallest_budget_is_one_generation():
    assert Sample().minimum_budget == 1
    assert load_optimizer("scatter", agents=7).minimum_budget == 7
    assert load_optimizer("cma-es").minimum_budget == 1


class Thawed(Optimizer):
    def minimize(self, objective, rng):
        """Do nothing."""


@dataclass(frozen=True)
class Unfinished(Optimizer):
    rate: float = 0.5


@dataclass(frozen=True)
class Demanding(Sample):
    def __init__(self, licence):
        super().__init__()


def test_only_a_frozen_dataclass_with_a_search_is_built():
    assert is_frozen(Sample)
    assert not is_frozen(Optimizer)
    assert build(Sample, "mine", {"size": 2}) == Sample(size=2)
    for cls in (Thawed, Unfinished):
        with pytest.raises(BenchError, match=r"'mine' .* must be a frozen dataclass that implements minimize"):
            build(cls, "mine", {})
    with pytest.raises(BenchError, match="optimizer 'mine' has no parameter 'sise'; did you mean 'size'"):
        build(Sample, "mine", {"sise": 2})
    with pytest.raises(BenchError, match=r"optimizer 'mine' cannot be made: .*licence.*; give its parameters defaults"):
        build(Demanding, "mine", {})
