"""The tables of methods."""

from pathlib import Path

import pytest

from bench.atlas.table import methods, parse
from bench.errors import BenchError

TABLE = """
technical = ["mode"]
[methods.climb]
title = "Hill climbing"
generation = 5
[[methods.climb.implementations]]
name = "hill-climber"
options = { sigma = 0.5 }
differs = "It climbs."
source = "its file"
[[methods.climb.implementations]]
name = "hill-climber"
label = "copy"
"""


def test_a_method_has_its_implementations_in_order():
    [method] = parse(TABLE, "mine.toml")
    assert (method.name, method.title, method.generation, method.technical) == (
        "climb", "Hill climbing", 5, ("mode",)
    )  # fmt: skip
    first, second = method.implementations
    assert (first.label, first.options, first.differs, first.source) == (
        "hill-climber", {"sigma": 0.5}, "It climbs.", "its file"
    )  # fmt: skip
    assert (second.label, second.key) == ("copy", "climb copy")


def test_a_file_adds_implementations_to_a_method_of_the_installed_table(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('[methods.gwo]\n[[methods.gwo.implementations]]\nname = "hill-climber"\n', encoding="utf-8")
    [method] = methods(file)
    labels = [each.label for each in method.implementations]
    assert labels[0] == "gwo"
    assert labels[-1] == "hill-climber"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("methods = ", "is no TOML"),
        ("methods = 3", "has methods = 3, which must be a table"),
        ("", "lacks the key 'methods'"),
        ("[methods.a]", "lacks the key 'implementations'"),
        ("[methods.a]\nimplementations = []", "has no implementation"),
        ("[methods.a]\nimplementations = [3]", "must be a table, not 3"),
        ("[methods.a]\nimplementations = [{}]", "lacks the key 'name'"),
        (
            "[methods.a]\nimplementations = [{name = 'gwo', option = {}}]",
            "unknown key 'option'; did you mean 'options'",
        ),
        ("[methods.a]\ngeneration = 0\nimplementations = [{name = 'gwo'}]", "must be a whole number of at least 1"),
        ("[methods.index]\nimplementations = [{name = 'gwo'}]", "no other page's"),
        ("[methods.'../a']\nimplementations = [{name = 'gwo'}]", "small letters, digits and hyphens"),
        ("[methods.a]\nimplementations = [{name = 'gwo'}, {name = 'gwo'}]", "give one another label"),
    ],
)
def test_a_wrong_table_costs_one_sentence(text, reason):
    with pytest.raises(BenchError, match=r"mine\.toml|two implementations") as raised:
        parse(text, "mine.toml")
    assert reason in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_missing_file_and_an_unknown_method_cost_one_sentence(tmp_path):
    with pytest.raises(BenchError, match="cannot be read: No such file"):
        methods(tmp_path / "none.toml")
    with pytest.raises(BenchError, match="the atlas has no method 'gwp'; did you mean 'gwo'"):
        methods(names=["gwp"])


def test_the_library_of_a_file_is_its_name():
    [method] = parse("[methods.a]\nimplementations = [{name = 'some/mine.py:Mine'}]", "mine.toml")
    [own] = method.implementations
    assert (own.label, own.library) == ("Mine", Path("mine.py").name)
