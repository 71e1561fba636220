"""Tables and figures as files: full precision, the same bytes for the same results, any label."""

import warnings

import matplotlib.figure
import pandas as pd
import pytest

from bench.plots import style
from bench.report import Figure, Table
from bench.report.page import inline
from bench.report.write import save_figure, save_table
from tests.bench.names import HOSTILE


def test_csv_has_full_precision(tmp_path):
    frame = pd.DataFrame({"x": [0.1 + 0.2, 1e-17, 123456789.123456789]})
    paths = save_table(Table("t", "c", frame, decimals=1), tmp_path, "t")
    lines = (tmp_path / paths[0]).read_text().split()
    assert [float(line) for line in lines[1:]] == frame["x"].tolist()


class TestFigures:
    @staticmethod
    def figure(title):
        with style.context():
            figure = matplotlib.figure.Figure(figsize=(style.PAGE, 2), layout="constrained")
            ax = figure.subplots()
            ax.set_title(style.plain(title))
            ax.plot([1, 2], [1, 2], "o-", clip_on=True)
            ax.bar([1], [1], hatch="///")
        return Figure("f", "c", figure, pd.DataFrame({"x": [1]}))

    @pytest.mark.sampled(3)
    @pytest.mark.parametrize("label", [*HOSTILE, "$\\frac{", "a$b$c", "bell\x07", "x" * 500])
    def test_any_label_can_be_drawn_and_warns_nobody(self, label, tmp_path):
        with warnings.catch_warnings(), style.context():
            warnings.simplefilter("error")
            svg, _ = save_figure(self.figure(label), tmp_path, "f")
        assert "<script" not in inline(svg, "f", label)
