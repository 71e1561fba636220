"""The figures of a report: sizes, fonts, and that no data or label can break one."""

import io

import pytest
from matplotlib.backends.backend_svg import FigureCanvasSVG

from bench import Results
from bench.plots import style
from bench.report.parts import Figure
from bench.topics.course import section as course
from bench.topics.findings import Findings
from bench.topics.runs import section as runs
from tests.bench.plots.frames import strict

HOSTILE = ("$a_1$ frac{", "日本語" * 9, "x" * 200, "x" * 199 + "y", "<b>&amp;", "a $ b", "evaluations")


def svg(figure):
    file = io.BytesIO()
    FigureCanvasSVG(figure).print_svg(file, metadata={"Date": None})
    return file.getvalue().decode()


@pytest.fixture(autouse=True)
def strictly(draws):
    with strict():
        yield


def every_figure(make, folder, optimizers, problems=("p", "q"), **more):
    """Return the figures of the sections on runs and on the budget."""
    findings = Findings(Results(make(folder, problems, optimizers, trials=3, **more)))
    with style.context():
        items = [item for each in (runs, course) if (made := each.section(findings)) for item in made.items]
    return [item for item in items if isinstance(item, Figure)]


@pytest.mark.parametrize("optimizers", [("one",), ("a", "b", "c"), HOSTILE], ids=["one", "three", "hostile"])
def test_each_is_drawn_in_a_width_of_the_page(make, tmp_path, optimizers):
    figures = every_figure(make, tmp_path / "s", optimizers, ("p", "$q$ 日本" * 20))
    for each in figures:
        assert svg(each.figure).startswith("<?xml")
        assert each.figure.get_figwidth() in (style.COLUMN, style.PAGE)
        assert each.table.rows
    assert [each.name for each in figures] == ["every-run", "targets-reached"]


def test_nothing_is_cut_off_and_the_same_data_give_the_same_bytes(make, tmp_path):
    optimizers = ("mealpy:AugmentedAEO", "W" * 24, "日本語" * 8)
    once, again = (every_figure(make, tmp_path / name, optimizers) for name in "st")
    for each, other in zip(once, again, strict=True):
        box, size = each.figure.get_tightbbox(), each.figure.get_size_inches()
        assert box.x0 >= -0.01, each.name
        assert box.y0 >= -0.01, each.name
        assert box.x1 <= size[0] + 0.01, each.name
        assert box.y1 <= size[1] + 0.01, each.name
        assert svg(each.figure) == svg(other.figure)
