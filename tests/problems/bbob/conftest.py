"""COCO's best points of the cases of a test module."""

import numba  # noqa: F401 - where it is loaded, one compiled loop calls COCO for all points
import pytest

from tests.problems.bbob.best import best_points


@pytest.fixture(scope="module")
def best(request, tmp_path_factory):
    return best_points(request.module.CASES, tmp_path_factory.mktemp("coco"))
