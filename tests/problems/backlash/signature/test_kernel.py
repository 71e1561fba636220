"""The fast objective equals the literal formula, everywhere; repaired points keep every constraint."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from problems.backlash.signature import kernel, model

CASES = {  # sampling period, samples, T_f, oscillations, time of the first sample
    "the published recordings": (0.002, 2401, 0.4, 24, 0.0),
    "the physical bench": (0.002, 2401, 0.408, 24, 0.0),
    "T_d between two samples": (0.002, 2401, 0.401, 24, 0.0),
    "T_d of 117.6 samples, a late start": (0.0017, 1800, 0.4, 24, 0.3),
    "more turns than the recording holds": (0.002, 900, 0.4, 24, 0.0),
    "fewer turns than the recording holds": (0.002, 2401, 0.4, 6, -1.0),
    "slow turns, fast sampling": (0.0005, 3000, 1.0, 4, 0.0),
    "turns faster than the box's T1 and T2": (0.002, 1000, 0.1, 18, 0.0),
    "a single oscillation": (0.002, 560, 0.4, 1, 18.99),
}


def case(name, seed=0):
    dt, n, period, replicas, start = CASES[name]
    rng = np.random.default_rng(seed)
    t = start + dt * np.arange(n)
    speed = np.sin(50 * t) + rng.normal(size=n)
    speed -= speed.mean()
    lower, upper = model.box(t, speed, period=period, amplitude_factor=1.3)
    folded = kernel.fold(speed, start=start, dt=dt, period=period, replicas=replicas)
    return t, speed, lower, upper, folded, {"period": period, "replicas": replicas}


def literal(points, t, speed, train):
    return np.array([model.rmse(speed, t, x, **train) for x in points])


def repaired(points, t, lower, upper, train):
    return kernel.repair(points, lower, upper, t[0], t[-1], train["period"] / 2)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", CASES)
def test_equals_the_literal_formula(name):
    t, speed, lower, upper, folded, train = case(name)
    rng = np.random.default_rng(1)
    inside = rng.uniform(lower, upper, (100, 7))
    sides = np.where(rng.random((100, 7)) < 0.5, lower, upper)
    edges = np.where(rng.random((100, 7)) < 0.5, sides, inside)
    overlapping = inside[:30].copy()
    overlapping[:, model.T1], overlapping[:, model.T2] = 0.0, upper[model.T2]
    points = np.vstack([inside, edges, overlapping, repaired(np.vstack([inside, edges]), t, lower, upper, train)])
    np.testing.assert_allclose(kernel.evaluate(points, folded), literal(points, t, speed, train), rtol=0, atol=1e-10)


def test_windows_that_end_on_a_sample_leave_it_out_in_every_turn():
    """0.204 is no exact multiple of 0.002 in binary: rounding must not let the end in here and out there."""
    t, speed, _, _, folded, train = case("the published recordings")
    points = np.array([[1.0, t0, 10.0, 134.0, 0.0, 0.0, t2] for t0 in (0.0, 0.1, 0.2) for t2 in (0.1, 0.2, 0.204)])
    np.testing.assert_allclose(kernel.evaluate(points, folded), literal(points, t, speed, train), rtol=0, atol=1e-12)
    assert folded.shift == 100
    wave = model.signature(t, points[1], **train)
    assert wave[100] == 0.0
    assert np.count_nonzero(wave[1:100]) == 99
    np.testing.assert_allclose(wave[200:2301], wave[:2101], atol=1e-12)


def test_far_outside_the_box_values_are_finite_or_infinitely_bad():
    folded = case("the published recordings")[4]
    rng = np.random.default_rng(4)
    points = rng.normal(size=(2000, 7)) * 10.0 ** rng.integers(0, 200, (2000, 1))
    values = kernel.evaluate(points, folded)
    assert (values > 0).all()
    assert np.isposinf(values).any()


@given(st.lists(st.floats(-1e3, 1e3), min_size=7, max_size=7), st.sampled_from(sorted(CASES)))
@settings(max_examples=200)
def test_repair_keeps_every_constraint_and_moves_nothing_twice(x, name):
    t, _, lower, upper, _, train = case(name)
    once = repaired(np.array([x]), t, lower, upper, train)[0]
    _, t0, _, omega, _, t1, t2 = once
    assert (once >= lower).all()
    assert (once <= upper).all()
    assert 0 <= t1 <= np.pi / (2 * omega)
    assert t1 <= t2 <= train["period"] / 2
    assert t[0] <= t0 <= t[-1] - t2 or t0 == t[0]
    np.testing.assert_array_equal(repaired(once[np.newaxis], t, lower, upper, train)[0], once)


def test_the_oscillation_is_that_of_eq_3_5():
    """Worked by hand: A exp(-tau (u - T1)) sin(omega u), 0 outside the open window."""
    x = np.array([2.0, 0.0, 10.0, 100.0, 0.0, 0.01, 0.05])
    u = np.array([0.0, 0.01, 0.02, 0.049, 0.05, 0.06])
    expected = [0.0, 0.0, 2 * np.exp(-0.1) * np.sin(2.0), 2 * np.exp(-0.39) * np.sin(4.9), 0.0, 0.0]
    np.testing.assert_allclose(model.oscillation(u, x), expected, rtol=1e-14)
