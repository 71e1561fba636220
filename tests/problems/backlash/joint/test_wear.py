"""The wear curve over months, and its recordings."""

import numpy as np
import pytest

from problems.backlash.joint import Joint, simulate
from problems.backlash.joint.wear import monthly_recordings, wear

CURVE = {"new": 0.0005, "worn": 0.002, "months": 3, "noise": 0.2, "duration": 0.4}


def months(seed=1, **changes):
    return list(monthly_recordings(Joint(), **{**CURVE, **changes}, seed=seed))


def test_wear_has_three_phases():
    life = np.linspace(0.0, 1.0, 2001)
    rate = np.gradient(wear(life), life)
    assert (wear(life[[0, -1]]) == [0.0, pytest.approx(1.0)]).all()
    assert (rate > 0).all()
    assert rate[:2] == pytest.approx(3.45, rel=0.03)  # running-in: 0.15 / 0.05 over the steady 0.45
    assert rate[(life > 0.35) & (life < 0.69)] == pytest.approx(0.45, rel=0.01)
    assert (np.diff(rate[life > 0.71]) > 0).sum() > 570  # and it accelerates to the end
    assert rate[-1] == pytest.approx(0.45 + 0.4 * 2 / 0.3, rel=0.01)


def test_a_month_holds_its_joint_s_recording_with_noise_and_the_truth():
    made = months(noise=0.1, start_angle=0.5)
    assert [month.name for month in made] == ["2024-01", "2024-02", "2024-03"]
    for month in made:
        clean = simulate(half_gap=month.half_gap, start_angle=0.5, duration=0.4)
        assert month.peak == clean.peak
        noise = month.speed - clean.speed
        assert 0.09 < np.ptp(noise) < 0.1
    assert not np.array_equal(made[0].speed[:5] - made[1].speed[:5], np.zeros(5))
