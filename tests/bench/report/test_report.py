"""The report's parts: words, tables, file names and figures."""

import warnings

import matplotlib.figure
import numpy as np
import pandas as pd
import pytest

from bench.plots import style
from bench.report import Figure, Table
from bench.report.output import save_figure, save_table
from bench.report.page import inline
from bench.report.wording import cell_text, count, listing, seconds, usual_decimals

HOSTILE = [
    "../../etc/passwd",
    "a/b:c",
    "<script>alert(1)</script>",
    "x & y_1 100% $z$ {q} ~ ^ \\",
    "..",
    "",
    "con\nnew",
    "日本",
]


class TestWords:
    @pytest.mark.parametrize(
        ("value", "decimals", "text"),
        [
            (True, None, "yes"), (np.bool_(False), None, "no"), (None, None, "–"), (float("nan"), 2, "–"),
            (float("inf"), 2, "∞"), (-float("inf"), None, "−∞"), (12345, None, "12,345"), (np.int64(7), 3, "7"),
            (1.23456, None, "1.235"), (1.23456, 1, "1.2"), (12345.6, 0, "12,346"), ("<b>", None, "<b>"),
        ],
    )  # fmt: skip
    def test_cells(self, value, decimals, text):
        assert cell_text(value, decimals) == text

    @pytest.mark.parametrize(
        ("values", "decimals"),
        [([2.5, 27.4], 2), ([0.5], 4), ([1e-9, 1.0], None), ([1e6], None), ([], None), ([123.0], 1)],
    )
    def test_decimals_show_four_digits_unless_values_span_too_much(self, values, decimals):
        assert usual_decimals(values) == decimals

    def test_sentences(self):
        assert count(1, "trial") == "1 trial"
        assert count(60_000, "evaluation") == "60,000 evaluations"
        assert listing(["a"]) == "a"
        assert listing(["a", "b", "c"]) == "a, b and c"
        assert listing(list("abcdef"), at_most=3) == "a, b and 4 more"
        assert (seconds(0.0123), seconds(3.456)) == ("12.3 ms", "3.46 s")


class TestTables:
    frame = pd.DataFrame(
        {"a_1": [1.25, float("inf")], "b": [2.0, float("nan")]}, index=pd.Index(["p&q", "r"], name="problem")
    )
    bold = pd.DataFrame({"a_1": [True, False]}, index=frame.index)
    table = Table("t", "100% of it", frame, bold=bold, italic=~bold, decimals={"a_1": 2, "b": 1}, note="x_y")

    def test_cells_are_formatted_and_marked(self):
        assert self.table.header == [("problem", False), ("a_1", True), ("b", True)]
        assert [[cell.text for cell in row] for row in self.table.rows] == [["p&q", "1.25", "2.0"], ["r", "∞", "–"]]
        assert [[(cell.bold, cell.italic) for cell in row] for row in self.table.rows] == [
            [(False, False), (True, False), (False, False)],
            [(False, False), (False, True), (False, False)],
        ]
        assert [row[0].heads_row for row in self.table.rows] == [True, True]

    def test_csv_has_full_precision(self, tmp_path):
        frame = pd.DataFrame({"x": [0.1 + 0.2, 1e-17, 123456789.123456789]})
        paths = save_table(Table("t", "c", frame, decimals=1), tmp_path, "t")
        lines = (tmp_path / paths[0]).read_text().split()
        assert [float(line) for line in lines[1:]] == frame["x"].tolist()

    def test_an_empty_table(self, tmp_path):
        save_table(Table("t", "c", pd.DataFrame({"x": []})), tmp_path, "t")


class TestFigures:
    @staticmethod
    def figure(title):
        with style.context():
            figure = matplotlib.figure.Figure(figsize=(style.TEXT, 2), layout="constrained")
            ax = figure.subplots()
            ax.set_title(style.plain(title))
            ax.plot([1, 2], [1, 2], "o-", clip_on=True)
            ax.bar([1], [1], hatch="///")
        return Figure("f", "c", figure, pd.DataFrame({"x": [1]}))

    @pytest.mark.parametrize("label", [*HOSTILE, "$\\frac{", "a$b$c", "bell\x07", "x" * 500])
    def test_any_label_can_be_drawn_and_warns_nobody(self, label, tmp_path):
        with warnings.catch_warnings(), style.context():
            warnings.simplefilter("error")
            svg, _ = save_figure(self.figure(label), tmp_path, "f")
        assert "<script" not in inline(svg, "f", label)

    def test_files_are_the_same_bytes_and_carry_no_date(self, tmp_path):
        for run in ("one", "two"):
            (tmp_path / run).mkdir()
            with style.context():
                _, paths = save_figure(self.figure("t"), tmp_path / run, "f")
        for path in paths:
            assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes()
        assert b"CreationDate" not in (tmp_path / "one/figures/f.pdf").read_bytes()
        assert b"dc:date" not in (tmp_path / "one/figures/f.svg").read_bytes()

    def test_looks_are_told_without_colour(self):
        looks = style.looks([str(i) for i in range(40)]).values()
        assert len({(look.color, look.marker, str(look.line)) for look in looks}) == 40
        assert len({look.marker for look in list(looks)[:7]}) == 7

    def test_offsets_are_fixed_and_bounded(self):
        assert np.abs(style.spread(1000)).max() <= 0.25
        assert (style.spread(5) == style.spread(5)).all()
