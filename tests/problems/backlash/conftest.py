import numpy as np
import pytest

from problems.backlash.recordings import Recording
from problems.backlash.sensor.estimate import Estimate, FittedRecording
from problems.backlash.signature.model import VARIABLES, signature
from problems.backlash.signature.problem import SignatureFit


@pytest.fixture(scope="session")
def make_estimate():
    """Return a function that makes the estimate of a half-gap in rad, whose recording is its fit and nothing else."""

    def make(gap=0.001, width=0.0001, **others):
        x = np.array([0.5, 0.05, 15.0, 134.0, 0.01, 0.01, 0.23])
        time = 0.002 * np.arange(601)
        fitted = 100 + signature(time, x, period=0.4, replicas=6)
        recording, variables = Recording(0.0, 0.002, fitted), dict(zip(VARIABLES, map(float, x), strict=True))
        problem = SignatureFit("recording", recording, turns=3)
        values = {
            "fit": FittedRecording(0.05, 0.9, variables, 0.4, "signal", 0.2, problem, recording, fitted),
            "amplitude_rps": 600 * gap, "amplitude_interval_rps": (600 * (gap - width), 600 * (gap + width)),
            "backlash_rad": gap, "interval_rad": (gap - width, gap + width),
            "verdict": "early", "p_value": 1e-9, "calibration": "a joint", "notes": (),
        }  # fmt: skip
        return Estimate(**(values | others))

    return make
