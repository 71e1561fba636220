"""Figures drawn here or in other processes: the same bytes, and what cannot be sent or fails is drawn here."""

import pickle

import matplotlib
import matplotlib.figure
import numpy as np
import pytest

from bench.plots import style
from bench.report.drawing import Drawer, Drawing, draw, draw_copy

pytestmark = pytest.mark.usefixtures("draws")


def figure(title="a title"):
    with style.context():
        made = matplotlib.figure.Figure(figsize=(style.COLUMN, 2), layout="constrained")
        ax = made.subplots()
        ax.set_title(title)
        ax.plot([1, 2, 3], [3, 1, 2], "o-", label="a label")
        ax.fill_between([1, 3], [0, 1], [2, 3], hatch="///")
        ax.legend()
    return made


@pytest.fixture(scope="module")
def elsewhere():
    """A drawer with another process."""
    with Drawer(2) as drawer:
        yield drawer


@pytest.fixture
def drawn_here(monkeypatch):
    """Return the figures that this process draws."""
    drawn = []

    def recorded(figure):
        drawn.append(figure)
        return draw(figure)

    monkeypatch.setattr("bench.report.drawing.draw", recorded)
    return drawn


@pytest.mark.slow
def test_another_process_draws_the_same_bytes(elsewhere, drawn_here):
    figures, plain = [figure("one"), figure("two")], [draw(figure("one")), draw(figure("two"))]
    elsewhere.begin(figures)
    assert [elsewhere.finish(each) for each in figures] == plain
    assert drawn_here == []
    with Drawer(1) as alone:
        alone.begin(figures := [figure("one"), figure("two")])
        assert [alone.finish(each) for each in figures] == plain
    assert drawn_here == figures


def test_a_user_s_own_settings_change_no_drawing():
    usual = draw(figure())
    with matplotlib.rc_context({"svg.fonttype": "path", "svg.hashsalt": None, "pdf.fonttype": 3}):
        assert draw(figure()) == usual


@pytest.mark.slow
def test_the_rest_is_drawn_here_and_only_once(elsewhere, drawn_here):
    figures = [figure(str(number)) for number in range(6)]
    elsewhere.begin(figures)
    elsewhere.help()
    helped = list(drawn_here)
    assert helped
    assert {id(each) for each in helped} <= {id(each) for each in figures}
    assert [elsewhere.finish(each) for each in figures] == [draw(figure(str(number))) for number in range(6)]
    assert drawn_here == helped


def test_what_cannot_be_pickled_is_drawn_here(elsewhere, drawn_here):
    with style.context():
        made = figure()
        made.axes[0].xaxis.set_major_formatter(lambda x, _: f"{x:.1f}")
    with pytest.raises(Exception, match="pickle"):
        pickle.dumps(made)
    elsewhere.begin([made])
    assert isinstance(elsewhere.finish(made), Drawing)
    assert drawn_here == [made]


def test_pyplot_s_own_figures_are_not_copied(elsewhere, drawn_here):
    from matplotlib import pyplot

    made = pyplot.figure()
    try:
        elsewhere.begin([made])
        assert elsewhere.finish(made).svg
        assert drawn_here == [made]
    finally:
        pyplot.close(made)


@pytest.mark.slow
def test_what_is_lost_on_its_way_is_drawn_here(elsewhere, drawn_here, monkeypatch):
    made = figure()
    with monkeypatch.context() as patch:
        patch.setattr("bench.report.drawing.draw_copy", int)  # which takes no such argument
        elsewhere.begin([made])
        assert elsewhere.finish(made) == draw(figure())
    assert drawn_here[0] is made


def test_a_figure_that_cannot_be_drawn_raises_where_its_drawing_is_asked_for(elsewhere):
    wrong = figure("$\\frac{$")  # is no mathematics
    elsewhere.begin([wrong, figure()])
    elsewhere.help()
    with pytest.raises(ValueError, match="frac"):
        elsewhere.finish(wrong)


def test_a_drawing_is_sent_as_json():
    answer = draw_copy(pickle.dumps(figure()))
    assert answer.keys() == {"svg", "pdf"}
    assert answer["svg"].encode() == draw(figure()).svg


@pytest.mark.slow
def test_many_points_are_drawn_as_the_same_image(elsewhere):
    def cloud():
        with style.context():
            made = matplotlib.figure.Figure(figsize=(style.COLUMN, 2))
            ax = made.subplots()
            ax.plot(*np.random.default_rng(0).random((2, 1000)), ".", rasterized=True)
        return made

    elsewhere.begin([made := cloud()])
    assert elsewhere.finish(made) == draw(cloud())


def test_a_figure_is_drawn_without_a_pdf_on_request():
    assert draw(figure(), pdf=False) == (draw(figure()).svg, None)
