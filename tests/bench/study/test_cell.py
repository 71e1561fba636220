"""A cell is all that decides a trial's bits but its number."""

from dataclasses import replace

import pytest

from bench import Study
from bench.study import Entry
from bench.study.cell import alike, with_inputs
from bench.study.rules import Rules

STUDY = Study("s", (Entry("p", "p"),), (Entry("o", "o", {"F": 0.5}),), budget="10 * d", seed=3)


def cell(study=STUDY, dimension=4):
    (one,) = study.cells({"p": dimension}).values()
    return one


@pytest.mark.parametrize(
    "changes",
    [
        {"budget": 41}, {"seed": 4}, {"rules": Rules(constraints="penalty")}, {"rules": Rules(on_error="worst")},
        {"rules": Rules(evaluation_timeout=5)}, {"rules": Rules(time="10 min")}, {"rules": Rules(final_target=1e-8)},
        {"problems": (Entry("q", "p"),)}, {"problems": (Entry("p", "p", {"shift": 1}),)},
        {"problems": (Entry("p", "q"),)},
        {"optimizers": (Entry("o", "o"),)}, {"optimizers": (Entry("o", "o", {"F": 0.6}),)},
    ],
)  # fmt: skip
def test_what_decides_a_trial_makes_another_cell(changes):
    assert cell(replace(STUDY, **changes)) != cell()


def test_other_dimensions_and_inputs_make_another_cell():
    assert cell(dimension=5) != cell()
    other = cell()._replace(optimizer=with_inputs(cell().optimizer, 2))
    assert other != cell() == other.bare
    assert alike(other.optimizer, cell().optimizer)


@pytest.mark.parametrize(
    "changes",
    [
        {"trials": 9},
        {"title": "Another"},
        {"targets": "tolerance"},
        {"budget": 40},
        {"name": "t"},
        {"rules": Rules(parallel=8, journal=True)},
    ],
)
def test_what_decides_no_trial_makes_none(changes):
    assert cell(replace(STUDY, **changes)) == cell()
