"""Figures drawn here or in other processes: the same bytes, and what cannot be sent or fails is drawn here."""

import pickle

import matplotlib
import matplotlib.figure
import pytest

from bench.plots import style
from bench.report.drawing import Drawer, Drawing

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


def test_what_cannot_be_pickled_is_drawn_here(elsewhere):
    with style.context():
        made = figure()
        made.axes[0].xaxis.set_major_formatter(lambda x, _: f"{x:.1f}")
    with pytest.raises(Exception, match="pickle"):
        pickle.dumps(made)
    elsewhere.begin([made])
    assert isinstance(elsewhere.finish(made), Drawing)


def test_a_figure_that_cannot_be_drawn_raises_where_its_drawing_is_asked_for(elsewhere):
    wrong = figure("$\\frac{$")  # is no mathematics
    elsewhere.begin([wrong, figure()])
    elsewhere.help()
    with pytest.raises(ValueError, match="frac"):
        elsewhere.finish(wrong)
