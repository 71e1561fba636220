"""Tables as cells that are formatted and marked, and sections that refuse what no page can show."""

import pandas as pd
import pytest

from bench.report import Card, Line, Section, Table, Typography


class TestTables:
    frame = pd.DataFrame(
        {"a_1": [1.25, float("inf")], "b": [2.0, float("nan")]}, index=pd.Index(["p&q", "r"], name="problem")
    )
    bold = pd.DataFrame({"a_1": [True, False]}, index=frame.index)
    table = Table(
        "t", "100% of it", frame, Typography(bold=bold, italic=~bold), decimals={"a_1": 2, "b": 1}, note="x_y"
    )

    def test_cells_are_formatted_and_marked(self):
        assert self.table.header == [("problem", False), ("a_1", True), ("b", True)]
        assert [[cell.text for cell in row] for row in self.table.rows] == [["p&q", "1.25", "2.0"], ["r", "∞", "–"]]
        assert [[(cell.bold, cell.italic) for cell in row] for row in self.table.rows] == [
            [(False, False), (True, False), (False, False)],
            [(False, False), (False, True), (False, False)],
        ]
        assert [row[0].heads_row for row in self.table.rows] == [True, True]


@pytest.mark.parametrize(
    "wrong",
    [
        {"cards": ("x",)}, {"text": "a text"}, {"text": (1,)}, {"text": (text for text in ("a", "b"))},
        {"items": "ab"}, {"items": ("x",)}, {"sections": (3,)}, {"lines": "careful"}, {"lines": ("a text",)},
        {"cards": (Card(None, "claim"),)}, {"lines": (Line("label", None),)},
    ],
)  # fmt: skip
def test_a_section_is_refused_at_its_source(wrong):
    with pytest.raises(TypeError):
        Section("title", **wrong)
