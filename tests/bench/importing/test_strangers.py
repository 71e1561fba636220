"""Data of COCO's own logger, as a stranger brings them: beside cocopp, and damaged in the ways of copies and disks."""

import json
import shutil
import tarfile
from importlib.util import find_spec

import numpy as np
import pytest

from bench import BenchError, Results, analysis
from bench.importing import import_results
from bench.report.findings import Findings
from tests.bench.export.made import read
from tests.bench.importing.test_coco import PRECISIONS, READ

LOGGER = """
import cocoex, numpy as np
home, suites = sys.argv[1], json.loads(sys.argv[3])
os.chdir(home)
rng = np.random.default_rng(3)
for suite in suites:
    logger = cocoex.Observer(suite, f"result_folder: {suite} algorithm_name: ES")
    functions = "1,2" if suite == "bbob-noisy" else "1,3"
    size = 5 if suite == "bbob-mixint" else 2
    for problem in cocoex.Suite(suite, "instances: 1-3", f"dimensions: {size} function_indices: {functions}"):
        problem.observe_with(logger)
        low, high = problem.lower_bounds, problem.upper_bounds
        while problem.evaluations < 600 and not problem.final_target_hit:  # a (1+1)-ES with restarts
            x, step, failed = rng.uniform(low, high), (high - low) / 5, 0
            f = problem(x)
            while problem.evaluations < 600 and not problem.final_target_hit and failed < 60:
                y = x + step * rng.standard_normal(len(x))
                g = problem(y)
                failed = 0 if g < f else failed + 1
                x, f, step = (y, g, 1.5 * step) if g <= f else (x, f, 1.5**-0.25 * step)
        problem.free()
print("{}")
"""
SUITES = ("bbob", "bbob-noisy", "bbob-mixint")
DAT, TDAT = "data_f1/bbobexp_f1_DIM2.dat", "data_f1/bbobexp_f1_DIM2.tdat"

pytestmark = pytest.mark.skipif(not find_spec("cocoex"), reason="COCO's own logger is the source")


@pytest.fixture(scope="module")
def logged(tmp_path_factory):
    """The folders of three suites."""
    place = tmp_path_factory.mktemp("logged")
    read(LOGGER, place, place, json.dumps(SUITES))
    return place / "exdata"


@pytest.fixture
def copied(logged, tmp_path):
    return shutil.copytree(logged / "bbob", tmp_path / "bbob")


def refused(folder, tmp_path, sentence):
    with pytest.raises(BenchError, match=sentence):
        import_results(folder, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads with cocopp and six")
@pytest.mark.parametrize("suite", SUITES)
def test_running_times_and_evaluations_are_those_of_cocopp(logged, tmp_path, suite):
    theirs = read(READ, logged / suite, tmp_path, json.dumps(PRECISIONS.tolist()))
    import_results(logged / suite, tmp_path / "out")
    found = Findings(Results(tmp_path / "out")).trials
    targets = analysis.precision_targets(found.problems, PRECISIONS)
    hits = analysis.hitting_times(found.frame, found.traces, targets, found.allowed)
    ours = analysis.expected_running_time(hits).set_index("problem")
    assert len(theirs) == 2
    for data in theirs:
        name = f"{suite}-f{data['function']:02d}-d{data['dimension']}"
        own = ours.loc[name].sort_values("tau", ascending=False)
        np.testing.assert_allclose(own["ert"].astype(float), data["ert"], rtol=1e-12)
    assert np.isfinite([data["ert"] for data in theirs]).any()


def test_several_suites_in_a_folder_are_named(logged, tmp_path):
    found = import_results(logged, tmp_path / "out")
    assert found.notes == ("The source holds results of 3 suites: bbob, bbob-mixint, bbob-noisy.",)
    assert found.problems == found.trials == 18


def test_a_log_without_its_last_rows_is_refused_though_the_other_log_has_them(copied, tmp_path):
    lines = (copied / DAT).read_text().splitlines(keepends=True)
    (copied / DAT).write_text("".join(lines[:-1]))
    refused(copied, tmp_path, r"DIM2\.dat is cut short: its last run lacks evaluation \d+, with which its \.tdat file")


@pytest.mark.parametrize("file", [DAT, TDAT])
def test_an_empty_log_is_refused(copied, tmp_path, file):
    (copied / file).write_text("")
    refused(copied, tmp_path, r"has \d runs and .* has \d; one of them is cut short")


def test_two_empty_logs_are_refused(copied, tmp_path):
    for file in (DAT, TDAT):
        (copied / file).write_text("")
    refused(copied, tmp_path, "ends before the run on instance 1")


@pytest.mark.parametrize("share", np.linspace(0.03, 0.97, 9))
def test_a_log_that_was_cut_anywhere_is_refused(copied, tmp_path, share):
    for file in (DAT, TDAT):
        content = (copied / file).read_bytes()
        (copied / file).write_bytes(content[: int(share * len(content))])
        with pytest.raises(BenchError, match=r"cut short|no numbers|comes before the header|without its f_opt"):
            import_results(copied, tmp_path / "out")
        (copied / file).write_bytes(content)


def test_an_archive_without_files_is_refused(tmp_path):
    with tarfile.open(tmp_path / "empty.tgz", "w:gz"):
        pass
    refused(tmp_path / "empty.tgz", tmp_path, r"empty\.tgz holds no results in a known format")
