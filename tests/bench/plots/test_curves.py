"""Curves over evaluations and targets: scales, where they end, and the axes of shares."""

import pytest

from bench import plots
from tests.bench.plots.frames import axes, curves, fractions, times


def test_an_infinite_median_is_not_drawn():
    ax = plots.convergence(curves(["p"], ["a", "b"]), "p", ax=axes())
    assert [line.get_xdata().tolist() for line in ax.lines] == [[5, 10, 20, 50, 99]] * 2
    assert ax.get_xscale() == "log"
    assert ax.get_yscale() == "linear"


@pytest.mark.parametrize(("number", "bands"), [(6, 6), (7, 0)])
def test_bands_are_drawn_as_long_as_they_can_be_distinguished(number, bands):
    optimizers = [f"o{place}" for place in range(number)]
    assert len(plots.convergence(curves(["p"], optimizers), "p", ax=axes()).collections) == bands


def test_a_curve_ends_in_an_open_marker_where_targets_are_left():
    ax = plots.ert(times(["p"], ["a", "b"], unreached=["b"]), "p", ax=axes())
    full, short, end = ax.lines
    assert full.get_xdata().tolist() == [1.0, 0.5, 0.1, 0.01, 0.001]
    assert short.get_xdata().tolist() == [1.0, 0.5, 0.1]
    assert (end.get_xdata()[0], end.get_markerfacecolor()) == (0.1, "white")
    left, right = ax.get_xlim()
    assert left > 1.0 > 0.001 > right


def test_shares_go_from_none_to_all():
    ax = plots.ecdf(fractions(["a"], "per_dimension"), ax=axes())
    assert ax.get_xlabel() == "evaluations / d"
    assert ax.get_ylim() == (-0.02, 1.02)
    assert plots.ecdf(fractions(["a"]), ax=axes()).get_xlabel() == "evaluations"
