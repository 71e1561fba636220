"""Timing, by hand."""

import pytest

from bench.analysis.timing import timing

pytestmark = pytest.mark.filterwarnings("error")


def test_by_hand(frame_of, one):
    frame = frame_of({("p", "a"): [1, 1, None], ("p", "b"): [1, 1]}).assign(
        wall_s=[1.0, 3.0, None, 2.0, 2.0],
        cpu_s=[1.0, 3.0, None, 1.0, 4.0],
        objective_s=[0.5, 1.5, None, 0, 0],
        nfev=300,
    )
    a = one(timing(frame), optimizer="a")
    assert (a.trials, a.wall_mean, a.wall_median, a.wall_q1, a.wall_q3) == (2, 2.0, 2.0, 1.5, 2.5)
    assert (a.objective_mean, a.objective_share, a.speed_median) == (1.0, 0.5, 200.0)
    assert (a.contention, a.hidden_threads) == (False, False)


@pytest.mark.parametrize(("cpu", "flags"), [(0.8, (True, False)), (1.0, (False, False)), (1.2, (False, True))])
def test_flags(frame_of, one, cpu, flags):
    frame = frame_of({("p", "a"): [1.0, 1.0]}, wall_s=1.0, cpu_s=cpu, objective_s=0.1, nfev=10)
    row = one(timing(frame))
    assert (row.contention, row.hidden_threads) == flags


def test_no_finished_trial_and_no_measurable_time(frame_of):
    frame = frame_of({("p", "a"): [None], ("p", "b"): [1.0]}, wall_s=0.0, cpu_s=0.0, objective_s=0.0, nfev=1)
    assert timing(frame)["trials"].tolist() == [0, 1]
