"""The matrix of medians: values that are compared can be distinguished, and every column is explained."""

import pandas as pd
import pytest

from bench import Results
from bench.report.latex import to_latex
from bench.report.page import grid
from bench.topics.comparison import section as comparison
from bench.topics.findings import Excerpt, Findings


def shown(findings):
    return comparison.section(findings).items[0]


@pytest.fixture
def close(make, tmp_path):
    """Return a study whose optimizers a and b differ by little: b always by the same."""
    changes = {"a": {"fun": 263.8961}, "b": {"fun": 263.9004}, "c": {"fun": 1.25}}
    return Findings(Results(make(tmp_path / "s", trials=4, changes=changes)))


def test_different_values_have_different_texts_in_every_file(close):
    table = shown(close)
    assert [cell.text for cell in table.rows[0]] == ["p", "263.896", "263.900", "1.25000"]
    assert "263.896" in to_latex(table, "t")
    assert [cell.text for cell in grid(table).rows[0]] == ["p", "263.896", "263.900", "1.25000"]


def test_turned_tables_keep_the_texts(close, monkeypatch):
    monkeypatch.setattr(Excerpt, "upright", True)
    texts = {row[0].text: row[1].text for row in shown(close).rows}
    assert texts == {"a": "263.896", "b": "263.900", "c": "1.25000"}


def test_the_column_of_other_winners_is_explained_where_it_stands(close, monkeypatch):
    assert "Lowest by" not in shown(close).note
    odd = pd.DataFrame({"problem": ["p"], "standing": [["c"]], "median": [["c"]], "mean": [["a"]]})
    monkeypatch.setitem(close.final.__dict__, "disagreements", odd)
    table = shown(close)
    assert table.frame["lowest by"].tolist() == ["mean a", ""]
    assert "Lowest by: the optimizer with the lowest median or mean" in table.note
    monkeypatch.setattr(Excerpt, "upright", True)
    assert "Lowest by" not in shown(close).note
