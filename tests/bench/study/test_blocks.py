"""The blocks that a study declares: read, written, refused, and the block of a problem."""

import tomllib

import pytest

from bench import BenchError, Study
from bench.study.blocks import Blocks


def study(**more):
    problems = [{"name": "sphere", "dimension": 2, "label": label} for label in ("f1-d2", "f1-d5", "own")]
    return Study.from_dict({"name": "s", "problems": problems, "optimizers": ["gwo"], **more})


@pytest.mark.parametrize("blocks", ["function", {"f1-d2": "one", "own": "one"}])
def test_a_study_keeps_its_blocks_and_its_identity(blocks):
    own = study(blocks=blocks)
    assert Study.from_dict(tomllib.loads(own.to_toml())) == own
    assert own.blocks == blocks
    assert own.identity() == study().identity()


def test_the_dimensions_and_instances_of_a_function_are_one_block():
    found = [Blocks("function").of(label) for label in ("f1-d2", "f1-d5", "f1-d2-i3", "own", "d2")]
    assert found == ["f1", "f1", "f1", "own", "d2"]


def test_a_table_has_the_block_of_a_problem_or_of_its_instances():
    blocks = Blocks({"f1-d2-i1": "one", "own": "two"})
    assert [blocks.of(label) for label in ("f1-d2", "own", "else")] == ["one", "two", ""]
    assert (blocks.within(["own"]), blocks.within(["else"])) == ({"own": "two"}, None)


@pytest.mark.parametrize("value", ["dimension", {}, {"f1": 3}, {"f1": ""}, 5, []])
def test_anything_else_is_refused(value):
    with pytest.raises(BenchError, match="must be 'function'"):
        Blocks.read(value, "'blocks'")


def test_a_block_of_no_problem_is_refused():
    with pytest.raises(BenchError, match="'blocks' names 'f1-d3', which is no problem"):
        study(blocks={"f1-d3": "one"})
