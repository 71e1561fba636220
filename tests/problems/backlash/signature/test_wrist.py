"""The simulated wrist of section 8.3: what its recordings hold."""

import numpy as np
import pytest

from bench import BenchError, load_problem
from problems.backlash.signature import wrist

# A in rps as the thesis expected it (Figs. 8.3b, 8.4b and 8.5b).
EXPECTED = {
    (4, "healthy"): 0.07, (4, "tampered"): 0.17, (5, "healthy"): 0.05, (5, "tampered"): 0.1, (6, "healthy"): 0.1,
    (6, "tampered"): 0.7,
}  # fmt: skip


def test_each_joint_has_the_amplitude_that_the_thesis_expected():
    for (number, state), expected in EXPECTED.items():
        assert wrist.recorded(f"wrist-{number}-{state}").peak == pytest.approx(expected, rel=0.01)


def test_one_oscillation_is_fitted_and_a_tampered_joint_has_the_larger_one():
    healthy, tampered = (load_problem(f"wrist-4-{state}") for state in wrist.STATES)
    assert healthy.replicas == tampered.replicas == 1
    assert abs(tampered.reference().x[0]) > 1.5 * abs(healthy.reference().x[0])


def test_another_draw_is_other_noise_on_the_same_motion():
    first, second = (wrist.recorded("wrist-5-tampered", draw).speed for draw in (0, 1))
    assert 0.05 < np.abs(first - second).max() < 0.1
    with pytest.raises(BenchError, match="draw must be a whole number"):
        load_problem("wrist-5-tampered", draw=-1)


def test_joint_1_is_the_noise_alone_at_any_gap():
    for state in wrist.STATES:
        assert wrist.recorded(f"wrist-1-{state}").peak < 0.005
    assert np.ptp(wrist.recorded("wrist-1-tampered").speed) < 0.11
