"""The final bests are distributed like those of the authors' codes (quantiles of hundreds to thousands of runs)."""

import numpy as np
import pytest

from optimizers.alo import ALO
from optimizers.da import DA
from optimizers.goa import GOA
from optimizers.gwo import GWO
from tests.optimizers.functions import final_bests

RUNS = 200
LEVELS = (0.05, 0.5, 0.95)
TOLERANCE = 1.05  # the published quantiles are rounded to two digits

PUBLISHED = [
    (ALO, "sphere", (3.5e-11, 4.4e-10, 7.3e-9)),
    (ALO, "rastrigin", (4.0, 13, 25)),
    (ALO, "rosenbrock", (0.75, 4.8, 250)),
    (GOA, "sphere", (9.5e-3, 1.7, 23)),
    (GOA, "rastrigin", (6.5, 19, 41)),
    (GOA, "rosenbrock", (2.2, 126, 1500)),
    (GWO, "sphere", (2.1e-4, 2.9e-3, 0.35)),
    (GWO, "rastrigin", (2.0, 6.0, 13)),
    (GWO, "rosenbrock", (3.0, 4.0, 5.1)),
    (DA, "sphere", (7.6e-8, 2.2e-4, 4.2e-2)),
    (DA, "rastrigin", (7.0, 20, 40)),
    (DA, "rosenbrock", (0.5, 6.3, 430)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("optimizer", "function", "quantiles"), PUBLISHED)
def test_final_bests_are_distributed_as_published(optimizer, function, quantiles):
    bests = final_bests(optimizer, function, RUNS, **({} if optimizer is DA else {"variant": "code"}))
    assert quantiles[0] < np.median(bests) < quantiles[2]
    for level, quantile in zip(LEVELS, quantiles, strict=True):
        slack = 3.5 * np.sqrt(level * (1 - level) / RUNS)  # of a binomial share
        assert (bests <= quantile * TOLERANCE).mean() > level - slack
        assert (bests >= quantile / TOLERANCE).mean() > 1 - level - slack
