"""The best of 2009: every time beside cocopp's own, and one sentence where it cannot be read."""

from importlib.util import find_spec

import numpy as np
import pytest
from typer.testing import CliRunner

from bench import BenchError, analysis
from bench.cli.app import app
from bench.importing import best2009
from tests.bench.export.made import read

COCOPP = """
import contextlib, warnings
warnings.simplefilter("ignore")
with contextlib.redirect_stdout(sys.stderr):
    import cocopp
    from cocopp import bestalg
    found, targets = {}, [10 ** (step / 5) * (1 + 1e-9) for step in range(10, -41, -1)]
    for suite in ("bbob", "bbob-noisy"):
        best = bestalg.load_reference_algorithm(f"refalgs/best2009-{suite}.tar.gz", force=True)
        for (dimension, function), entry in best.items():
            name = f"{suite}-f{function:02d}-d{dimension}"
            found[name] = [float(ert) for ert in entry.detERT(targets)]
print(json.dumps(found))
"""

needs_cocopp = pytest.mark.skipif(
    not (find_spec("cocopp") and find_spec("six")), reason="the best of 2009 is read from cocopp, which needs six"
)


@pytest.fixture(autouse=True)
def anew():
    best2009._suite.cache_clear()
    yield
    best2009._suite.cache_clear()


@needs_cocopp
@pytest.mark.slow
def test_all_times_equal_those_of_cocopp(tmp_path):
    """54 functions in 6 dimensions, at COCO's 51 precisions."""
    theirs = read(COCOPP, tmp_path, tmp_path)
    assert len(theirs) == 54 * 6
    table = analysis.reference_times(
        best2009.best2009(theirs), dict(zip(theirs, theirs, strict=True)), analysis.COCO_PRECISIONS
    )
    ours = table["ert"].to_numpy().reshape(len(theirs), -1)
    found = np.array([theirs[name] for name in theirs])
    differ = ours != found
    # cocopp loses the last row of a log whose precision is printed one rounding above COCO's target
    assert differ.sum() <= 3
    assert np.isfinite(ours[differ]).all()
    assert np.isinf(found[differ]).all()
    assert np.isinf(ours).any()


@needs_cocopp
def test_problems_are_found_with_and_without_instance():
    one, other = (best2009.best2009([name, "sphere-2"]) for name in ("bbob-f08-d5-i71", "bbob-f08-d5"))
    assert one.equals(other)
    assert set(one["problem"]) == {"bbob-f08-d5"}


def test_a_study_without_such_a_problem_is_refused():
    with pytest.raises(BenchError, match=r"has running times on bbob and bbob-noisy .* the study has no such problem"):
        best2009.best2009(["signature-12", "bbob-largescale-f01-d20-i1"])


def test_without_cocopp_the_sentence_names_the_extra(monkeypatch):
    monkeypatch.setattr(best2009, "find_spec", lambda name: None)
    with pytest.raises(BenchError, match=r"read from cocopp, which is not installed; .*'backlash-bench\[coco\]'"):
        best2009.best2009(["bbob-f01-d2-i1"])


def test_a_cocopp_without_the_data_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(best2009, "_package", lambda: tmp_path)
    with pytest.raises(BenchError, match=r"the installed cocopp has no best2009-bbob\.tar\.gz"):
        best2009.best2009(["bbob-f01-d2-i1"])


def test_a_run_whose_problems_have_none_is_refused_before_its_first_trial(tmp_path, monkeypatch):
    (tmp_path / "s.toml").write_text(
        'name = "s"\nbudget = 10\nproblems = [{name = "classical-sphere-d2"}]\n'
        'optimizers = [{name = "random-search"}]\n'
    )
    monkeypatch.chdir(tmp_path)
    found = CliRunner().invoke(app, ["run", "s.toml", "--against", "best2009"])
    assert isinstance(found.exception, BenchError)
    assert "the study has no such problem" in str(found.exception)
    assert not (tmp_path / "results").exists()
