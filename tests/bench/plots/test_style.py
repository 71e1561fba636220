"""The look that all plots share, whose axes they draw on, and which problems they refuse."""

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

from bench import BenchError, plots
from bench.plots import style
from tests.bench.plots.frames import axes, clock, curves, fractions, improvements, times, trials


def test_a_title_has_as_many_letters_as_its_panel_has_room_for():
    _, panels = style.grid(3, width=4.8, height=1.0, left=0.6, across=0.3)
    style.title(panels[0], "a-problem-with-a-long-name-d10")
    assert panels[0].get_title(loc="left") == "a-problem-wit…me-d10"


def test_long_labels_stay_apart():
    labels = [f"mealpy:Original{i:02d}Optimizer" for i in range(12)] + ["gwo", "x" * 500]
    names = style.names(labels, 20)
    assert len(set(names.values())) == len(labels)
    assert max(map(len, names.values())) <= 20
    assert names["gwo"] == "gwo"
    assert style.names(labels[3:5] + labels[:3] + labels[5:], 20) == names  # whatever their order


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
    ("limits", "wanted"),
    [((1, 60_000), "10,000"), ((1, 2e6), "10⁴"), ((1e-8, 1), "10⁻⁸"), ((1e-8, 1), "10⁰"), ((0.01, 1), "0.01")],
)
def test_log_axes_have_plain_numbers_or_powers_alone(limits, wanted):
    ax = axes()
    ax.set_xlim(*limits)
    style.log_scale(ax, "x")
    ax.figure.draw_without_rendering()
    assert wanted in [tick.get_text() for tick in ax.get_xticklabels()]


def test_functions_draw_on_the_axes_given_or_on_new_ones():
    from matplotlib import pyplot

    frame = trials({("p", "a"): [1.0, 2.0]})
    draw = [
        lambda ax: plots.box_plot(frame, "p", ax=ax),
        lambda ax: plots.convergence(curves(["p"], ["a"]), "p", ax=ax),
        lambda ax: plots.ert(times(["p"], ["a"]), "p", ax=ax),
        lambda ax: plots.ecdf(fractions(["a"]), ax=ax),
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


def pens_of(labels, **options):
    return {label: (each.color, each.marker, str(each.line)) for label, each in style.pens(labels, **options).items()}


class TestLooks:
    def test_all_differ_and_the_first_colours_are_taken_once(self):
        assert len(set(pens_of([str(i) for i in range(280)]).values())) == 280
        assert len({color for color, _, _ in pens_of([f"o{i}" for i in range(8)]).values()}) == 8

    def test_they_are_the_same_in_every_process_and_version(self):
        known = {"cma-es": "#009E73", "gwo": "#000000", "random-search": "#8C6D31"}
        assert {label: color for label, (color, _, _) in pens_of(list(known)).items()} == known

    def test_another_optimizer_seldom_changes_a_colour(self):
        changed = 0
        for study in range(100):
            labels = [f"{study} {i}" for i in range(5)]
            before, after = pens_of(labels), pens_of([*labels, "one more"])
            changed += sum(before[label] != after[label] for label in labels)
        assert changed < 0.15 * 500  # by their order, one that comes first would change all

    def test_the_best_keep_their_looks_whatever_becomes_of_the_others(self):
        labels, best = [f"o{i}" for i in range(20)], ["o3", "o7", "o11"]
        grey, coloured = style.pens(labels, best), style.pens(labels, best, grey=False)
        assert [label for label, each in grey.items() if not each.background] == best
        assert {label: grey[label] for label in best} == {label: coloured[label] for label in best} == style.pens(best)
        assert len({(each.color, each.marker, str(each.line)) for each in coloured.values()}) == 20

    def test_every_colour_is_seen_on_white_and_on_a_dark_page(self):
        def luminance(color):
            parts = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
            linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
            return linear @ [0.2126, 0.7152, 0.0722]

        for color in set(style.PALETTE) - {"#000000"}:  # the page has its own ink for black
            for page in ("#ffffff", "#14171b"):
                low, high = sorted([luminance(color), luminance(page)])
                assert (high + 0.05) / (low + 0.05) > 2, (color, page)


def test_a_subject_stands_out_and_its_rivals_are_paler():
    pens = style.pens("abc")
    shown = style.standing_out(pens, "b")
    assert shown["b"].color == pens["b"].color
    assert shown["b"].width > 1
    assert all(shown[label].color != pens[label].color for label in "ac")
    assert len({(pen.color, pen.marker, str(pen.line)) for pen in shown.values()}) == 3
    assert style.behind_first(shown)[-1][0] == "b"
    assert style.standing_out(pens, "") == pens


def test_the_name_of_a_subject_is_bold_at_an_axis_and_in_a_legend():
    figure, (ax,) = style.grid(1, height=1.0, left=1.0)
    style.name_rows(ax, ["a", "subject"])
    style.legend_above(figure, style.handles(style.pens(["a", "subject"])))
    style.mark(figure, "subject")
    assert [text.get_fontweight() for text in ax.get_yticklabels()] == ["normal", "bold"]
    assert [text.get_fontweight() for text in figure.legends[0].texts] == ["normal", "bold"]


def test_long_labels_of_a_sweep_show_the_values_that_differ():
    labels = [f"RestartDE[agents=15,F={f},cr=0.9,restart=true,start={s}]" for f in (0.5, 0.7) for s in ("a", "b")]
    names = style.names([*labels, "gwo", "x[1]"], 24)
    assert [names[label] for label in labels] == [
        "RestartDE[F=0.5,start=a]", "RestartDE[F=0.5,start=b]", "RestartDE[F=0.7,start=a]", "RestartDE[F=0.7,start=b]",
    ]  # fmt: skip
    assert names["gwo"] == "gwo"
    assert style.names(labels[:1], 24)[labels[0]] == style.plain(labels[0], 24)  # nothing differs
