"""The space of a tuning: declared ranges, those that types imply, and ranges that are none."""

from dataclasses import dataclass
from typing import Any, Literal

import pytest

from bench import BenchError, Optimizer, load_optimizer, parameter
from bench.optimizer import CONDITIONS
from bench.tuning.space import Axis, space


def axes(**fields):
    """Return the axes, by name, of an optimizer with fields of these (type, default)."""
    own = {"__annotations__": {name: kind for name, (kind, _) in fields.items()}}
    kind = type("Made", (Optimizer,), own | {name: each for name, (_, each) in fields.items()} | {"minimize": None})
    return {axis.name: axis for axis in space("made", dataclass(frozen=True)(kind)(), (), 1000, CONDITIONS)}


def test_ranges_and_choices_follow_declarations_and_types():
    found = axes(
        declared=(float, parameter(0.5, tune=(0.1, 2.0))),
        both=(float, parameter(0.5, minimum=0, maximum=1)),
        wide=(float, parameter(1e-3, minimum=1e-6, maximum=1.0)),
        whole=(int, parameter(5, minimum=1, tune=(2, 9), log=True)),
        switch=(bool, True),
        kind=(Literal["a", "b"] | None, None),
        listed=(float, parameter(1.0, tune=[1.0, 3.0])),
        free=(float, 1.0),
        text=(str, "x"),
        anything=(Any, 7),
        kept=(bool, parameter(True, tune=[])),
    )
    assert found == {
        "declared": Axis("declared", 0.5, low=0.1, high=2.0),
        "both": Axis("both", 0.5, low=0.0, high=1.0),
        "wide": Axis("wide", 1e-3, low=1e-6, high=1.0, log=True),
        "whole": Axis("whole", 5, whole=True, low=2, high=9, log=True),
        "switch": Axis("switch", True, choices=(False, True)),
        "kind": Axis("kind", None, choices=("a", "b")),
        "listed": Axis("listed", 1.0, choices=(1.0, 3.0)),
    }


def test_a_population_has_a_range_without_a_declaration_and_no_more_than_the_budget():
    assert axes(agents=(int, parameter(30, minimum=7)))["agents"] == Axis("agents", 30, True, 7, 300, True)
    assert axes(agents=(int | None, None))["agents"] == Axis("agents", None, True, 5, 300, True)
    (axis,) = space("scatter", load_optimizer("scatter"), (), 60, ["agents"])
    assert (axis.low, axis.high) == (5, 60)


def test_the_defaults_lie_in_the_space_and_limit_nothing_else():
    assert axes(a=(float, parameter(9.0, tune=(0.1, 2.0))))["a"].high == 9.0
    assert load_optimizer("cma-es", sigma=5.0).sigma == 5.0  # above what is tried


def test_fixed_parameters_are_left_out():
    found = space("gwo", load_optimizer("gwo"), ["agents"], 900, CONDITIONS)
    assert [axis.name for axis in found] == ["handling", "variant"]


def test_conditions_are_tuned_only_where_they_are_asked_for():
    def names(*conditions):
        return [axis.name for axis in space("cma-es", load_optimizer("cma-es"), (), 900, conditions)]

    assert names() == ["sigma", "active"]
    assert names("start") == ["start", "sigma", "active"]
    with pytest.raises(
        BenchError, match=r"'da' has no parameter to tune; .* or ask for a condition, as in --condition"
    ):
        space("da", load_optimizer("da"), (), 900)


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        (parameter(1.0, tune=(2.0, 2.0)), "parameter 'a' of 'made' is none: 2 to 2; its low end must be the smaller"),
        (parameter(1.0, tune=(3.0, 2.0)), "is none: 3 to 2"),
        (parameter(1.0, tune=(float("nan"), 2.0)), "is none: nan to 2"),
        (parameter(1.0, tune=(0.0, 2.0), log=True), "begins at 0; a logarithmic one must begin above 0"),
        (parameter(1.0, minimum=1.0, tune=(0.5, 2.0)), "0.5 to 2, exceeds the values that it accepts"),
        (parameter(1.0, tune=(1.0,)), "must be two numbers, such as (0.1, 1), not (1.0,)"),
        (parameter(1.0, tune=[1.0]), "the only value to tune of parameter 'a' of 'made' is 1.0"),
        (parameter(1.0, tune=[[1.0], [2.0]]), "must be numbers, texts, or true and false"),
        (1.0, "'made' has no parameter to tune; declare a range"),
    ],
)
def test_what_cannot_be_searched_costs_one_sentence(declared, said):
    with pytest.raises(BenchError) as caught:
        axes(a=(float, declared))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "name",
    ["gwo", "alo", "goa", "da", "cma-es", "cma-es-fast", "bipop-cma-es", "random-search",
     "scipy:differential_evolution", "scipy:dual_annealing", "scipy:direct", "scipy:basinhopping"],
)  # fmt: skip
def test_both_ends_of_every_declared_range_are_accepted(name):
    found = space(name, load_optimizer(name), (), 10_000, CONDITIONS)
    assert found
    for axis in found:
        for value in axis.choices or (axis.low, axis.high):
            load_optimizer(name, **{axis.name: value})
