"""Targets reached: where curves end, and the axes of shares."""

import numpy as np

from bench import plots
from tests.bench.plots.frames import axes, fractions, svg, times


def test_a_curve_ends_in_an_open_marker_where_targets_are_left():
    ax = plots.ert(times(["p"], ["a", "b"], unreached=["b"]), "p", ax=axes())
    full, short, end = ax.lines
    assert full.get_xdata().tolist() == [1.0, 0.5, 0.1, 0.01, 0.001]
    assert short.get_xdata().tolist() == [1.0, 0.5, 0.1]
    assert (end.get_xdata()[0], end.get_markerfacecolor()) == (0.1, "white")
    left, right = ax.get_xlim()
    assert left > 1.0 > 0.001 > right


def test_a_problem_on_which_no_target_was_reached_has_axes_all_the_same():
    ax = plots.ert(times(["p"], ["a"]).assign(ert=np.inf), "p", ax=axes())
    svg(ax.figure)
    assert [len(line.get_xdata()) for line in ax.lines] == [0]


def test_shares_go_from_none_to_all():
    ax = plots.data_profile(fractions(["a"], "groups"), ax=axes())
    assert ax.get_xlabel() == "groups of d + 1 evaluations"
    assert ax.get_ylim() == (-0.02, 1.02)
    assert plots.data_profile(fractions(["a"]), ax=axes()).get_xlabel() == "evaluations"
