"""pycma's CMA-ES, to the last bit, without the work in Python for points that nobody has changed."""

from __future__ import annotations

from typing import Any

import numpy as np
from cma import CMAEvolutionStrategy
from cma.evolution_strategy import get_CMASolutionDict
from cma.sampler import GaussFullSampler
from cma.transformations import GenoPheno

from bench.typing import Floats


class Strategy(CMAEvolutionStrategy):  # type: ignore[misc]
    """pycma's CMA-ES without bounds, for a loop of :meth:`ask` and ``tell(points, values, check_points=False)``.

    pycma keeps books on each point, so that a caller may change points, inject some or hand in others: it archives all
    it sends and looks them up again. In this loop, all points come from :meth:`ask` unchanged, and the books are left
    out where they would return each point itself. All arguments are pycma's.
    """

    def __init__(self, x0: Floats, sigma0: float, options: dict[str, Any]) -> None:
        super().__init__(x0, sigma0, options)
        self.sent_solutions = get_CMASolutionDict(functional=False)()
        self.gp.__class__ = Coordinates
        if type(self.sm) is GaussFullSampler:
            self.sm.__class__ = Sampler

    def ask(self) -> list[Floats] | Floats:
        """Return the lambda points of pycma's ``ask``, without a copy and an archive entry for each.

        Once pycma searches an ill-conditioned problem in other coordinates (its ``alleviate_conditioning``), ``tell``
        needs the archive to find a point's coordinates to the last bit.
        """
        points: Floats = self.ask_geno()
        if self.gp.isidentity:
            return points
        if isinstance(self.sent_solutions, get_CMASolutionDict(functional=False)):
            self.sent_solutions = get_CMASolutionDict(functional=True)()
        mapped = [self.gp.pheno(point, copy=True) for point in points]
        for image, point in zip(mapped, points, strict=True):
            self.sent_solutions.insert(image, geno=point, iteration=self.countiter)
        return mapped

    def _clean_injected_solutions_archive(self, pop: Floats) -> Any:
        """Return the indices of injected points: pycma hashes every point, also where it has injected none."""
        return super()._clean_injected_solutions_archive(pop) if len(self._injected_solutions_archive) else []


class Coordinates(GenoPheno):  # type: ignore[misc]
    """pycma's map between the points and the search's own coordinates, which at first is the identity."""

    def geno(
        self, y: Floats, from_bounds: Any = None, copy: bool = True, repair: Any = None, archive: Any = None
    ) -> Any:
        """Return the coordinates of the point ``y``."""
        return y if self.isidentity and repair is None else super().geno(y, from_bounds, copy, repair, archive)


class Sampler(GaussFullSampler):  # type: ignore[misc]
    """pycma's normal distribution, which weighs all vectors with negative weights at once."""

    def update(self, vectors: Any, weights: Any, c1_times_delta_hsigma: float = 0) -> None:
        """Add the weighted outer products of the (n, d) ``vectors`` to C (Hansen, arXiv:1604.00772, eq. 47).

        A negative weight is divided by the vector's squared Mahalanobis length (eq. 46). pycma takes these lengths one
        by one. Here BLAS makes the same products in one call, sums are taken in the same order, and the powers remain
        those of numpy's scalars, from which sqrt and square differ in last digits.
        """
        x, w = np.asarray(vectors), np.array(weights)
        total = w.cumsum()[-1]
        negative = w < 0
        white = (self.B.T @ x[negative, :, np.newaxis])[..., 0] / self.D
        lengths = (white**2).cumsum(axis=1)[:, -1]
        w[negative] *= [self.dimension / (length**0.5 + 1e-9) ** 2 for length in lengths]
        if not (np.isfinite(x[0, 0]) and np.isfinite(lengths).all() and np.isfinite(w).all()):
            super().update(x, weights, c1_times_delta_hsigma)  # which raises an error
            return
        self.C *= 1 + c1_times_delta_hsigma - total
        self.C += np.dot(w * x.T, x)
        self.count_tell += 1
