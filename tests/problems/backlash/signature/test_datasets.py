"""Noisy recordings with a random start, as in section 7.3."""

import numpy as np
import pytest

from bench import load_problem
from problems.backlash.published.recordings import table_7_3
from problems.backlash.signature.datasets import dataset, noisy, peak_to_peak


def cut(made):
    return 2401 - len(made.speed)


def noise_of(made, level):
    clean = dataset(level).speed if level else np.full(2401, 100.0)
    return made.speed - clean[cut(made) :]


@pytest.mark.parametrize("level", table_7_3().index)
def test_the_low_noise_is_that_of_table_7_3_and_the_high_one_half_as_strong_again(level):
    printed = table_7_3().at[level, "noise"]  # with digits cut off
    assert peak_to_peak(level) / 2 == pytest.approx(printed, abs=1e-4)
    assert peak_to_peak(level, "high") == pytest.approx(1.5 * peak_to_peak(level))


def test_a_recording_begins_at_0_s_with_one_of_the_first_100_samples_of_its_dataset():
    cuts = [cut(noisy(2, draw=draw)) for draw in range(200)]
    assert (min(cuts), max(cuts)) == (0, 99)
    made = noisy(2)
    assert (made.start, made.dt) == (0.0, 0.002)
    assert np.abs(noise_of(made, 2)).max() <= peak_to_peak(2) / 2


def test_level_noise_and_draw_decide_the_signal_and_nothing_else_does():
    first = noisy(3, "low", 1)
    assert np.array_equal(first.speed, noisy(3, "low", 1).speed)
    assert [cut(noisy(2, "low", draw)) for draw in range(3)] == [83, 42, 84]  # on every machine, today and later

    def shape(level, noise, draw):
        made = noisy(level, noise, draw)
        return noise_of(made, level)[-2000:] / peak_to_peak(level, noise)

    others = [shape(4, "low", 1), shape(3, "high", 1), shape(3, "low", 2)]
    assert max(abs(np.corrcoef(shape(3, "low", 1), other)[0, 1]) for other in others) < 0.1


def test_a_problem_has_the_truth_of_its_dataset_and_the_noise_of_its_draw():
    problem = load_problem("noisy-05", unit="rpm", noise="high", draw=4)
    clean = load_problem("signature-05", unit="rpm")
    assert problem.expected == clean.expected
    assert problem.unit == "rpm"
    assert len({p.signal.tobytes() for p in (problem, clean, load_problem("noisy-05", unit="rpm", noise="high"))}) == 3
