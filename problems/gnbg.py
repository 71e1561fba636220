"""The family ``gnbg``: the 24 instances of GNBG-II, as the package ``iohgnbg`` has them.

The competition's rule is 30 runs of 500,000 evaluations on f01 to f15 and of 1,000,000 on f16 to f24, and a precision
of 1e-8; the studies ``gnbg-f01-f15`` and ``gnbg-f16-f24`` have it. A value is the error, f - f*, as in the package. The
package itself evaluates no more than that budget, keeps all values, and fails with numpy 2.4; so its instances and its
transformation are used, and its formula is written here with the same steps, so that no bit differs.

Sources: Yazdani, Omidvar, Yazdani, Deb and Gandomi 2023, "GNBG: A Generalized and Configurable Benchmark Generator for
Continuous Numerical Optimization", arXiv:2312.07083; Gandomi, Salgotra and Deb 2025, "Numerical Global Optimization
Competition on GNBG-II generated Test Suite", GECCO and CEC.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench import Problem
from bench.contract.families import Grid, Member
from bench.contract.typing import Floats
from bench.helpers.errors import require
from problems.common import Suite, SuiteProblem, features_of, group_of

DIMENSION = 30

GROUPS = {
    "unimodal": range(1, 7),
    "multimodal, one component": range(7, 16),
    "multimodal, several components": range(16, 25),
}
"""The functions of each group, as the competition has them."""


def _problem(name: str, member: Member) -> Problem:
    iohgnbg = require("iohgnbg", "ioh", f"problem {name!r} needs")
    from scipy.io import loadmat

    number = int(member.function[1:])
    folder = Path(iohgnbg.get_static_package_path()) / iohgnbg.GNBG_COMPETITION_INSTANCES
    data = loadmat(folder / f"f{number}.mat")["GNBG"][0, 0]
    transform = iohgnbg.GNBG.transform
    rotations = np.atleast_3d(data["RotationMatrix"])
    components = [
        (position[:, None], rotations[:, :, k], data["Component_H"][k], data["Mu"][k], data["Omega"][k],
         data["ComponentSigma"][k], data["lambda"][k])
        for k, position in enumerate(data["Component_MinimumPosition"])
    ]  # fmt: skip

    def fitness(point: Floats) -> float:
        values: list[float] = []
        for position, rotation, height, mu, omega, sigma, power in components:
            offset = point[:, None] - position
            left = transform(None, offset.T @ rotation.T, mu, omega)
            right = transform(None, rotation @ offset, mu, omega)
            values.append((sigma + (left @ np.diag(height) @ right) ** power)[0, 0])
        return min(values)

    def evaluate(x: Floats) -> Floats:
        values: Floats = np.array([fitness(point) for point in x], dtype=np.float64) - data["OptimumValue"][0, 0]
        return values

    lower, upper = (np.full(DIMENSION, float(data[key][0, 0])) for key in ("MinCoordinate", "MaxCoordinate"))
    features = features_of("gnbg", member, group_of(number, GROUPS))
    known = {"optimum": 0.0, "optimum_point": data["OptimumPosition"].ravel(), "features": features}
    return SuiteProblem(evaluate, lower, upper, name=name, **known)


gnbg = Suite(Grid("gnbg", {f"f{number:02d}": (DIMENSION,) for number in range(1, 25)}), _problem)
