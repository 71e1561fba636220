"""Sweeps: what lists in a table ``options`` become, and how labels show it again."""

import tomllib

import pytest

from bench import BenchError, Study
from bench.study.sweep import swept

MINIMAL = {"name": "s", "problems": [{"name": "sphere-2"}]}


def study(*optimizers):
    return Study.from_dict(MINIMAL | {"optimizers": list(optimizers)})


def labels(*optimizers):
    return [entry.label for entry in study(*optimizers).optimizers]


def test_every_combination_is_an_optimizer_whose_label_names_its_values():
    found = study({"name": "gwo", "handling": "box", "options": {"agents": [30, 100], "variant": ["code", "cascade"]}})
    assert [entry.label for entry in found.optimizers] == [
        "gwo[agents=30,variant=code]",
        "gwo[agents=30,variant=cascade]",
        "gwo[agents=100,variant=code]",
        "gwo[agents=100,variant=cascade]",
    ]
    assert found.optimizers[1].options == {"handling": "box", "agents": 30, "variant": "cascade"}
    assert found.optimizer("gwo[agents=100,variant=code]").agents == 100
    assert {swept(entry.label, entry.options) for entry in found.optimizers} == {("gwo", ("agents", "variant"))}


def test_a_frozen_study_is_the_same_study():
    given = study({"name": "cma-es", "options": {"active": [True, False], "sigma": [0.1, 0.3], "handling": "box"}})
    frozen = Study.from_dict(tomllib.loads(given.to_toml()))
    assert frozen == given
    assert frozen.identity() == given.identity()
    assert "options" not in given.to_toml()


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"options": {"agents": []}}, "the list of values of 'agents' of 'gwo' is empty"),
        ({"options": {"agents": [5, 5]}}, "the list of values of 'agents' of 'gwo' holds a value twice"),
        ({"options": {"a": list(range(40)), "b": list(range(40))}}, "has 1,600 combinations, more than 1,000"),
        ({"options": [1]}, "'options' of an optimizer must be a table, not [1]"),
        ({"agents": 5, "options": {"agents": [5, 6]}}, "'agents' is given twice, in 'options' and beside it"),
        ({"options": {"label": ["a"]}}, "'label' is no parameter; write it beside 'options'"),
    ],
)
def test_what_cannot_be_swept_costs_one_sentence(entry, said):
    with pytest.raises(BenchError) as caught:
        study({"name": "gwo", **entry})
    assert said in str(caught.value)
