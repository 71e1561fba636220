"""The pictures show what was estimated, in the kind of file asked for."""

from pathlib import Path

import numpy as np
import pytest

from problems.backlash.sensor.batch import Estimated
from problems.backlash.sensor.estimate import Settings
from problems.backlash.sensor.plots import fit_figure, save_figures
from problems.backlash.sensor.recording_files import Series
from problems.backlash.sensor.trend import trend

NONE = Settings(calibration=None)


@pytest.fixture
def trends(make_estimate):
    def make(name, gaps, unit="month"):
        at = np.arange(len(gaps)) + (24288.0 if unit == "month" else 1.0)
        return trend(
            Series(name, tuple(range(len(gaps))), at, unit), [make_estimate(gap) for gap in gaps], limit_rad=0.0021
        )

    return make


def lines(ax, label):
    return [line for line in ax.get_lines() if line.get_label() == label]


def test_the_fit_its_half_turn_and_the_rest_are_drawn(make_estimate):
    fit = make_estimate().fit
    above, middle, below = fit_figure(fit).axes
    np.testing.assert_array_equal(lines(above, "recording")[0].get_ydata(), fit.recording.speed)
    np.testing.assert_array_equal(lines(above, "fit")[0].get_ydata(), fit.fitted)
    assert np.abs(below.get_lines()[0].get_ydata()).max() == 0.0
    (mean,) = lines(middle, "their mean")
    fine = middle.get_lines()[-1]
    off = np.abs(mean.get_ydata() - np.interp(mean.get_xdata(), *fine.get_data()))
    assert (off < 0.02).sum() >= len(off) - 1  # but for the jump
    assert off[2] < 0.006 < 0.012 < abs(mean.get_ydata()[2])  # where the oscillation before has not ended
    assert 0.4 < fine.get_ydata().max() == fine.get_ydata()[np.abs(fine.get_ydata()).argmax()]


@pytest.mark.slow
def test_files_and_folders_are_written_and_the_same_estimate_gives_the_same_file(make_estimate, trends, tmp_path):
    outcomes = [Estimated(Path("x/a.csv"), make_estimate()), Estimated(Path("y/a.csv"), make_estimate())]
    grown = [trends("", [0.001, 0.002])]
    folder = tmp_path / "new"
    made = save_figures(folder, outcomes, grown, NONE, alone=False)
    assert made == [folder / name for name in ("a.svg", "a-2.svg", "trend.svg")]
    assert made[0].read_bytes() == made[1].read_bytes()
    for name, start in (("b.svg", b"<?xml"), ("b.pdf", b"%PDF"), ("b.png", b"\x89PNG")):
        assert save_figures(tmp_path / name, outcomes, grown, NONE, alone=False) == [tmp_path / name]
        assert (tmp_path / name).read_bytes().startswith(start)
    assert (tmp_path / "b.svg").read_bytes() == made[2].read_bytes()
    assert save_figures(tmp_path / "c.svg", outcomes, [], NONE, alone=False) == []
    assert save_figures(tmp_path / "c.svg", outcomes[:1], [], NONE, alone=True) == [tmp_path / "c.svg"]
    assert (tmp_path / "c.svg").read_bytes() == made[0].read_bytes()
