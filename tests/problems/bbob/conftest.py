"""COCO's best points of the cases of a test module."""

import pytest

from tests.problems.bbob.best import best_points


@pytest.fixture(scope="module")
def best(request, tmp_path_factory):
    return best_points(request.module.CASES, tmp_path_factory.mktemp("coco"))
