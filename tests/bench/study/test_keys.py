"""Keys that a study's file does not have: one sentence names what does their work, all of which exists."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from bench import BenchError, Study
from bench.cli.app import PANELS
from bench.study.keys import ELSEWHERE

ROOT = Path(__file__).resolve().parents[3]
KEYS = {field.name for field in fields(Study)}
COMMANDS = {command for commands in PANELS.values() for command in commands}


@pytest.mark.parametrize(("key", "said"), ELSEWHERE.items())
def test_a_key_that_no_study_has_names_what_does_its_work(key, said):
    with pytest.raises(BenchError) as caught:
        Study.from_dict({"name": "s", key: 1, "problems": ["sphere-2"], "optimizers": ["gwo"]})
    assert str(caught.value) == f"study given: unknown key {key!r}; {said}"
    assert {*re.findall(r"'(\w+)'", said), *re.findall(r"\[\[(\w+)\]\]", said)} <= KEYS
    assert set(re.findall(r"'bench (\w+)'", said)) <= COMMANDS
    assert all((ROOT / page).is_file() for page in re.findall(r"docs/\S+\.md", said))


def test_another_unknown_key_names_the_nearest():
    with pytest.raises(BenchError, match=r"unknown key 'trails'; did you mean 'trials'\?"):
        Study.from_dict({"name": "s", "trails": 1})
