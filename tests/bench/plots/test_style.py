"""The look that all plots share, whose axes they draw on, and which problems they refuse."""

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

from bench import BenchError, plots
from bench.plots import style
from tests.bench.plots.frames import axes, clock, curves, fractions, improvements, ranks_of, times, trials


@pytest.mark.parametrize(("count", "length"), [(1, 3), (7, 3), (30, 20)])
def test_a_legend_above_takes_the_height_it_says(count, length):
    texts = [f"{'x' * length}{i}" for i in range(count)]
    figure, (ax,) = style.grid(1, height=1.0, left=0.5, top=style.legend_height(texts))
    for text in texts:
        ax.plot([0, 1], [0, 1], label=text)
    style.legend_above(figure, ax.get_legend_handles_labels()[0])
    figure.draw_without_rendering()
    box = figure.legends[0].get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    assert box.x1 <= style.TEXT
    assert box.y0 >= figure.get_figheight() - style.legend_height(texts)
    assert [text.get_text() for text in figure.legends[0].texts] == texts


def test_long_labels_stay_apart():
    labels = [f"mealpy:Original{i:02d}Optimizer" for i in range(12)] + ["gwo", "x" * 500]
    names = style.names(labels, 20)
    assert len(set(names.values())) == len(labels)
    assert max(map(len, names.values())) <= 20
    assert names["gwo"] == "gwo"
    assert style.names(labels[3:5] + labels[:3] + labels[5:], 20) == names  # whatever their order


def test_widths_are_measured():
    assert style.text_width([]) == 0.0
    assert style.text_width(["i"]) < style.text_width(["W"]) < style.text_width(["i", "WW"])
    assert style.text_width(["日" * 10], 8.0) >= 10 * 8 / 72


def test_a_grid_has_the_margins_asked_for():
    figure, panels = style.grid(
        5, columns=3, width=6.0, height=1.0, left=0.5, right=0.25, bottom=0.4, top=0.3, across=0.2, down=0.1
    )
    np.testing.assert_allclose(figure.get_size_inches(), [6.0, 0.4 + 0.3 + 2 * 1.0 + 0.1])
    assert len(panels) == len(figure.axes) == 5
    boxes = [np.array(ax.get_position().extents) * np.tile(figure.get_size_inches(), 2) for ax in panels]
    np.testing.assert_allclose(boxes[0][[0, 3]], [0.5, 2.8 - 0.3])
    np.testing.assert_allclose(boxes[2][2], 6.0 - 0.25)
    np.testing.assert_allclose(boxes[3][1], 0.4)
    np.testing.assert_allclose(boxes[1][0] - boxes[0][2], 0.2)
    np.testing.assert_allclose(boxes[0][1] - boxes[3][3], 0.1)


@pytest.mark.parametrize(
    ("limits", "wanted"), [((1, 60_000), "10,000"), ((1, 2e6), "1e4"), ((1e-8, 1), "1e-8"), ((0.01, 1), "0.01")]
)
def test_log_axes_have_plain_numbers(limits, wanted):
    ax = axes()
    ax.set_xlim(*limits)
    style.log_scale(ax, "x")
    ax.figure.draw_without_rendering()
    assert wanted in [tick.get_text() for tick in ax.get_xticklabels()]


def test_functions_draw_on_the_axes_given_or_on_new_ones():
    from matplotlib import pyplot

    frame, ranks = trials({("p", "a"): [1.0, 2.0]}), ranks_of(["a", "b"])
    draw = [
        lambda ax: plots.box_plot(frame, "p", ax=ax),
        lambda ax: plots.convergence(curves(["p"], ["a"]), "p", ax=ax),
        lambda ax: plots.regret(curves(["p"], ["a"]), "p", ax=ax),
        lambda ax: plots.ert(times(["p"], ["a"]), "p", ax=ax),
        lambda ax: plots.ecdf(fractions(["a"]), ax=ax),
        lambda ax: plots.data_profile(fractions(["a"], "groups"), ax=ax),
        lambda ax: plots.cd_diagram(ranks, ax=ax),
        lambda ax: plots.a12_forest(improvements(["a", "b"]), ax=ax),
        lambda ax: plots.timing(clock(["a"]), ax=ax),
    ]
    for function in draw:
        given = axes()
        assert function(given) is given
    with matplotlib.rc_context({"backend": "agg"}):
        pyplot.close("all")
        for function in draw:
            assert isinstance(function(None), Axes)
        assert len(pyplot.get_fignums()) == len(draw)
        pyplot.close("all")


@pytest.mark.parametrize("draw", [plots.box_plot, plots.convergence, plots.ert, plots.a12_forest])
def test_a_problem_that_is_not_there_is_refused_by_name(draw):
    frame = pd.DataFrame({"problem": ["sphere-2"], "optimizer": ["a"]})
    with pytest.raises(BenchError, match="no problem 'sphere-3' to draw; did you mean 'sphere-2'"):
        draw(frame, "sphere-3")


def test_looks_differ_without_colour():
    looks = style.looks([str(i) for i in range(40)]).values()
    assert len({(look.color, look.marker, str(look.line)) for look in looks}) == 40
    assert len({look.marker for look in list(looks)[:7]}) == 7


def test_offsets_are_fixed_and_bounded():
    assert np.abs(style.spread(1000)).max() <= 0.25
    assert (style.spread(5) == style.spread(5)).all()
