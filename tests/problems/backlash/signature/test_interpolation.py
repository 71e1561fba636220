import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from problems.backlash.signature.interpolation import Pchip


@pytest.mark.parametrize("points", [2, 3, 4, 25])
@pytest.mark.parametrize("grows", [True, False])
def test_the_curve_is_that_of_scipy(points, grows):
    rng = np.random.default_rng(points)
    for _ in range(20):
        x = np.cumsum(rng.exponential(size=points) + 1e-3)
        y = np.cumsum(rng.exponential(size=points) ** 4 if grows else rng.integers(-1, 2, points))
        between = np.concatenate([x, rng.uniform(x[0], x[-1], 50)])
        ours, theirs = Pchip(x, y), PchipInterpolator(x, y, extrapolate=False)
        np.testing.assert_allclose([ours(value) for value in between], theirs(between), rtol=1e-13, atol=1e-13)


def test_there_is_no_curve_outside_the_points():
    curve = Pchip(np.array([1.0, 2.0, 3.0]), np.array([1.0, 4.0, 9.0]))
    assert np.isnan([curve(0.999), curve(3.001), curve(np.nan)]).all()
    assert (curve(1.0), curve(3.0)) == (1.0, 9.0)
