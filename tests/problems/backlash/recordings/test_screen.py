"""Recordings that are unfit are refused, and all others are accepted."""

import re
from itertools import product

import numpy as np
import pytest

from bench import BenchError
from problems.backlash.recordings import Recording, read
from problems.backlash.recordings.screen import screen, warnings
from problems.backlash.signature.datasets import dataset
from tests.problems.backlash.cut import cut

RNG = np.random.default_rng(0)
S = dataset(12).speed
T = 0.002 * np.arange(len(S))
NOISE = RNG.uniform(-0.15, 0.15, len(S))


def recording(speed, dt=0.002, unit="rps"):
    return Recording(0.0, dt, np.asarray(speed, dtype=float), unit)


def digits(speed, count):
    return np.array([float(f"{value:.{count}g}") for value in speed])


@pytest.mark.parametrize("level", range(1, 21))
def test_a_good_recording_passes_however_it_is_noisy_rounded_or_cut(level):
    speed, rng = dataset(level).speed, np.random.default_rng(level)
    for span, decimals in product((0.0, 0.1, 0.75), (None, 1, 2, 3)):
        noisy = speed + span * rng.uniform(-0.5, 0.5, len(speed))
        made = recording(noisy if decimals is None else np.round(noisy, decimals))
        screen(made, period=0.4)
        screen(cut(made, 0.3, 0.7), period=0.4)
    screen(recording(digits(speed, 5)), period=0.4)  # as the published ones: 99.987 and 100.12
    screen(recording(-speed), period=0.4)
    assert warnings(recording(speed), period=0.4) == []


def test_the_published_recordings_pass(published):
    for level in (3, 5, 8, 11, 12):
        made = read(published / f"Speeddata{level}.xlsx")
        screen(made, period=0.4)
        assert warnings(made, period=0.4) == [made.assumed]  # the files have no headings


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    "speed", [S, S + NOISE, np.round(S, 3), np.round(S + NOISE, 2), digits(S, 5), S[:110]], ids=lambda s: f"{s[3]:.6g}"
)
@pytest.mark.parametrize("part", [0.6, 0.3])
def test_a_clipped_peak_is_seen(side, speed, part):
    limit = 100 + part * (S.max() - 100)
    made = recording(side * np.minimum(speed, limit))
    where = "highest" if side > 0 else "lowest"
    with pytest.raises(BenchError, match=rf"clipped: \d+ samples lie in flat runs at its {where} value"):
        screen(made)


RAMP = np.linspace(0, 99, 300)


@pytest.mark.parametrize(
    ("speed", "what", "window"),
    [
        (np.concatenate([RAMP, S, RAMP[::-1]]), "starts or stops", (0.6, 5.4)),
        (np.concatenate([S, np.zeros(700)]), "starts or stops", (0.0, 4.8)),
        (np.concatenate([S[:1000], RAMP[::-1], -RAMP, -S]), "reverses", (3.2, 8.0)),
        (np.concatenate([S, S * 1.5]), "leaves its speed by more than a fifth", (0.0, 4.8)),
        (np.concatenate([100 * (1 - np.exp(-T / 0.12)), S]), "starts or stops", (0.5, 9.6)),
    ],
)
def test_a_motion_that_is_not_steady_is_refused_with_the_part_that_is(speed, what, window):
    made = recording(speed)
    with pytest.raises(BenchError, match=f"the motor {what}.*longest steady part, --window") as caught:
        screen(made)
    begin, end = map(float, re.search(r"--window ([\d.]+):([\d.]+)", str(caught.value)).groups())
    assert begin == pytest.approx(window[0], abs=0.15)
    assert end == pytest.approx(window[1], abs=0.15)
    part = cut(made, begin, end)
    screen(part)
    assert not any("--window" in message for message in warnings(part))


@pytest.mark.parametrize(
    ("made", "options", "message"),
    [
        (recording(np.full(500, 100.0)), {}, "the speed is constant at 100 rps"),
        (recording(np.full(500, 600.0) / 60 + 1e-15 * RNG.uniform(size=500)), {}, "the speed is constant at 10 rps"),
        (recording(np.where(T == 1.0, np.nan, S)), {}, "the speed at 1 s is not a number"),
        (recording(NOISE), {}, "the motor reverses (its speed is -0.1"),
        (recording(S[:150]), {"period": 0.4}, "lasts 0.298 s, less than one load turn of 0.4 s"),
        (
            recording(S[::15], dt=0.03),
            {"period": 0.4},
            "is too coarse for a load turn of 0.4 s; sample at 50 Hz at least",
        ),
    ],
)
def test_other_defects_are_reported_in_one_sentence(made, options, message):
    with pytest.raises(BenchError) as caught:
        screen(made, **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
