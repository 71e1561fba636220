"""The example programs of a simulator, the box that they have, and points in it."""

from pathlib import Path

import numpy as np

SIMULATORS = Path(__file__).parents[2] / "examples" / "simulator"
BOX = {
    "variables": ["height", "width", "ribs"], "lower": [50, 20, 1], "upper": [200, 100, 8],
    "integer": [False, False, True],
}  # fmt: skip
X = np.array([[120.5, 40.25, 3.0], [60.0, 20.0, 1.0], [200.0, 100.0, 8.0]])
