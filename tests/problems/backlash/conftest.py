import numpy as np
import pytest

from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Estimate
from problems.backlash.signature.model import VARIABLES, signature
from problems.backlash.signature.problem import SignatureFit


@pytest.fixture(scope="session")
def make_estimate():
    """Return a function that makes the estimate of a half-gap in rad, whose recording is its fit and nothing else."""

    def make(gap=0.001, width=0.0001, **others):
        x = np.array([0.5, 0.05, 15.0, 134.0, 0.01, 0.01, 0.23])
        time = 0.002 * np.arange(601)
        fitted = 100 + signature(time, x, period=0.4, replicas=6)
        values = {
            "amplitude_rps": 600 * gap, "amplitude_interval_rps": (600 * (gap - width), 600 * (gap + width)),
            "backlash_rad": gap, "interval_rad": (gap - width, gap + width), "rmse_rps": 0.05, "explained": 0.9,
            "verdict": "early", "variables": dict(zip(VARIABLES, map(float, x), strict=True)), "period_s": 0.4,
            "period_source": "signal", "delay_s": 0.2, "p_value": 1e-9,
            "calibration": "a joint", "notes": (),
            "recording": Recording(0.0, 0.002, fitted), "fitted": fitted,
        }  # fmt: skip
        problem = SignatureFit("recording", Recording(0.0, 0.002, fitted), turns=3)
        return Estimate(**({"problem": problem} | values | others))

    return make
