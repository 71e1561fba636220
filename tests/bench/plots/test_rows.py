"""Dots of runs: what they draw, and what they say of the rest."""

from bench import plots
from tests.bench.plots.frames import axes, trials


def test_every_run_is_a_dot_and_its_optimizer_s_median_a_line():
    values = [-1.0, -2.0, -3.0, -4.0, -100.0, float("inf")]
    ax = plots.runs(trials({("p", "a"): values, ("q", "a"): [7.0]}), "p", ax=axes())
    (dots,) = ax.collections
    assert sorted(dots.get_offsets()[:, 0]) == sorted(values[:-1])
    assert [line.get_xdata().tolist() for line in ax.lines] == [[-3.0]]
    assert [text.get_text().strip() for text in ax.texts] == ["1✗"]
