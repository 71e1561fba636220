"""Noisy recordings with a random start, as in section 7.3."""

import numpy as np
import pytest
from scipy.stats import kstest

from bench import BenchError, load_problem
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


@pytest.mark.parametrize(("level", "noise"), [(0, "low"), (2, "low"), (11, "high"), (20, "high")])
def test_the_noise_is_uniform_white_and_about_zero(level, noise):
    added = noise_of(noisy(level, noise), level)
    width = peak_to_peak(level, noise)
    assert kstest(added, "uniform", (-width / 2, width)).pvalue > 0.01
    assert abs(np.corrcoef(added[1:], added[:-1])[0, 1]) < 4 / np.sqrt(len(added))


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


def test_without_backlash_there_is_the_reference_speed_and_noise_alone():
    made = noisy(0)
    assert (made.peak, made.half_gap) == (0.0, None)
    assert made.speed.mean() == pytest.approx(100, abs=0.01)
    problem = load_problem("noisy-00")
    assert dict(problem.expected) == {"amplitude_rpm": (0.0, problem.expected["amplitude_rpm"][1])}


def test_a_problem_has_the_truth_of_its_dataset_and_the_noise_of_its_draw():
    problem = load_problem("noisy-05", unit="rpm", noise="high", draw=4)
    clean = load_problem("signature-05", unit="rpm")
    assert problem.expected == clean.expected
    assert problem.unit == "rpm"
    assert len({p.signal.tobytes() for p in (problem, clean, load_problem("noisy-05", unit="rpm", noise="high"))}) == 3


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("noisy-21", {}, "unknown problem 'noisy-21'; did you mean 'noisy-2"),
        ("noisy-02", {"nois": "high"}, "has no option 'nois'; did you mean 'noise'"),
        ("noisy-02", {"noise": "mid"}, "noise must be one of 'low', 'high', not 'mid'"),
        ("noisy-02", {"draw": -1}, "draw must be a whole number of at least 0, not -1"),
    ],
)
def test_an_unknown_dataset_or_option_is_refused_in_one_sentence(name, options, message):
    with pytest.raises(BenchError, match=message.replace("?", r"\?")):
        load_problem(name, **options)
