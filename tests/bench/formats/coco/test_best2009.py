"""The best of 2009: every time beside cocopp's own, and one sentence where it cannot be read."""

import sys
from importlib.util import find_spec
from itertools import product

import numpy as np
import pandas as pd
import pytest

from bench import BenchError
from bench.analysis.reference import reference_times, runlength_targets
from bench.formats.coco import best2009
from bench.study.targets import COCO_PRECISIONS
from tests.bench.formats.made import read

COCOPP = """
import contextlib, warnings
warnings.simplefilter("ignore")
with contextlib.redirect_stdout(sys.stderr):
    import cocopp
    from cocopp import bestalg
    found, by_length, targets = {}, {}, [10 ** (step / 5) * (1 + 1e-9) for step in range(10, -41, -1)]
    for suite in ("bbob", "bbob-noisy"):
        best = bestalg.load_reference_algorithm(f"refalgs/best2009-{suite}.tar.gz", force=True)
        for (dimension, function), entry in best.items():
            name = f"{suite}-f{function:02d}-d{dimension}"
            found[name] = [float(ert) for ert in entry.detERT(targets)]
        lengths = cocopp.pproc.RunlengthBasedTargetValues(
            [0.5, 1.2, 3, 10, 50], reference_data=best, force_different_targets_factor=10**-0.2
        )
        for dimension, function in best:
            at = [float(each) for each in lengths((function, dimension))]
            by_length[f"{suite}-f{function:02d}-d{dimension}"] = at
print(json.dumps([found, by_length]))
"""

needs_cocopp = pytest.mark.skipif(
    not (find_spec("cocopp") and find_spec("six")), reason="the best of 2009 is read from cocopp, which needs six"
)


@pytest.fixture(autouse=True)
def anew():
    best2009._suite.cache_clear()
    yield
    best2009._suite.cache_clear()


@pytest.fixture(scope="module")
def cocopp_s(tmp_path_factory):
    """The running times at COCO's 51 precisions, and the targets by running length, of each function in cocopp."""
    place = tmp_path_factory.mktemp("cocopp")
    return read(COCOPP, place, place)


@needs_cocopp
@pytest.mark.slow
def test_all_times_equal_those_of_cocopp(cocopp_s):
    """54 functions in 6 dimensions, at COCO's 51 precisions."""
    theirs, _ = cocopp_s
    assert len(theirs) == 54 * 6
    levels = pd.DataFrame(product(theirs, COCO_PRECISIONS), columns=["problem", "precision"])
    table = reference_times(best2009.best2009(theirs), dict(zip(theirs, theirs, strict=True)), levels)
    ours = table["ert"].to_numpy().reshape(len(theirs), -1)
    found = np.array([theirs[name] for name in theirs])
    differ = ours != found
    # cocopp loses the last row of a log whose precision is printed one rounding above COCO's target
    assert differ.sum() <= 3
    assert np.isfinite(ours[differ]).all()
    assert np.isinf(found[differ]).all()
    assert np.isinf(ours).any()


def targets_of(names):
    same = dict(zip(names, names, strict=True))
    dimensions = {name: int(name.rpartition("-d")[2]) for name in names}
    table = runlength_targets(best2009.best2009(names), same, dimensions)
    return {str(name): own["precision"].tolist() for name, own in table.groupby("problem")}


@needs_cocopp
@pytest.mark.slow
def test_all_targets_by_running_length_equal_those_of_cocopp(cocopp_s):
    """54 functions in 6 dimensions, 5 budgets."""
    _, theirs = cocopp_s
    assert len(theirs) == 54 * 6
    assert targets_of(theirs) == theirs


@needs_cocopp
def test_some_targets_by_running_length_are_those_that_cocopp_printed():
    """The next, the last and forced ones; those of f16 are nearly equal by rounding, so that none is forced."""
    theirs = {
        "bbob-f01-d20": [63.09573451111506, 39.81071709516044, 1e-08, 1e-08, 1e-08],
        "bbob-f02-d2": [3981071.709516042, 1584893.194046008, 39810.71709516043, 0.3981071709516044, 1e-08],
        "bbob-f16-d20": [39.81071709516044, 25.118864340214667, 15.84893194046007, 15.848931940460062, 10.00000001],
    }  # fmt: skip
    found = targets_of(theirs)
    for name, targets in theirs.items():
        assert found[name] == pytest.approx(targets, rel=1e-12)


@needs_cocopp
def test_problems_are_found_with_and_without_instance():
    one, other = (best2009.best2009([name, "sphere-2"]) for name in ("bbob-f08-d5-i71", "bbob-f08-d5"))
    assert one.equals(other)
    assert set(one["problem"]) == {"bbob-f08-d5"}


def test_without_cocopp_the_sentence_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cocopp", None)
    with pytest.raises(BenchError, match=r"read from cocopp, which is not installed; .*'backlash-bench\[coco\]'"):
        best2009.best2009(["bbob-f01-d2-i1"])


def test_a_cocopp_without_the_data_is_named(monkeypatch, tmp_path):
    (tmp_path / "cocopp").mkdir()
    (tmp_path / "cocopp" / "__init__.py").touch()
    monkeypatch.delitem(sys.modules, "cocopp", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(BenchError, match=r"the installed cocopp has no best2009-bbob\.tar\.gz"):
        best2009.best2009(["bbob-f01-d2-i1"])
