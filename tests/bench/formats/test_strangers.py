"""Data of COCO's own logger, as a stranger brings them: beside cocopp, and damaged in the ways of copies and disks."""

import json
import shutil
from importlib.util import find_spec

import numpy as np
import pytest

from bench import BenchError, Results, analysis
from bench.formats.importing import import_results
from bench.topics.findings import Findings
from tests.bench.formats.coco.test_reader import PRECISIONS, READ
from tests.bench.formats.made import precision_targets, read

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


@pytest.mark.sampled(1)
@pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads with cocopp and six")
@pytest.mark.parametrize("suite", SUITES)
def test_running_times_and_evaluations_are_those_of_cocopp(logged, tmp_path, suite):
    theirs = read(READ, logged / suite, tmp_path, json.dumps(PRECISIONS.tolist()))
    import_results(logged / suite, tmp_path / "out")
    found = Findings(Results(tmp_path / "out")).trials
    targets = precision_targets(found.problems, PRECISIONS)
    hits = analysis.hitting_times(found.frame, found.traces, targets, found.allowed)
    ours = analysis.expected_running_time(hits).set_index("problem")
    assert len(theirs) == 2
    for data in theirs:
        name = f"{suite}-f{data['function']:02d}-d{data['dimension']}"
        own = ours.loc[name].sort_values("tau", ascending=False)
        np.testing.assert_allclose(own["ert"].astype(float), data["ert"], rtol=1e-12)
    assert np.isfinite([data["ert"] for data in theirs]).any()


def test_a_mixture_of_suites_is_refused_by_name(logged, tmp_path):
    refused(logged, tmp_path, "exdata holds results of 3 suites, bbob, bbob-mixint and bbob-noisy; import the folder")


@pytest.mark.parametrize(
    ("files", "left", "sentence"),
    [
        (
            [DAT],
            lambda text: text[: text.rstrip().rindex(b"\n") + 1],
            r"run on instance 3 lacks evaluation \d+, with which",
        ),
        ([DAT], lambda _: b"", r"has \d runs and .* has \d; one of them is cut short"),
        ([TDAT], lambda _: b"", r"has \d runs and .* has \d; one of them is cut short"),
        ([DAT, TDAT], lambda _: b"", "ends before the run on instance 1"),
        *(
            ([file], lambda text, share=share: text[: int(share * len(text))], "cut short|no numbers|without its f_opt")
            for share in np.linspace(0.03, 0.97, 9)
            for file in (DAT, TDAT)
        ),
    ],
)
def test_a_log_that_was_cut_anywhere_is_refused(copied, tmp_path, files, left, sentence):
    for file in files:
        (copied / file).write_bytes(left((copied / file).read_bytes()))
    refused(copied, tmp_path, sentence)


ODD = {
    2: (  # a last improvement that equals a target
        "1:4|1.0e+01, 1:9|6.0e+00",
        [None, (1, 30.0), (2, 15.0), None, (1, 30.0), (3, 7.0), (9, 6.0)],
        [None, (1, 30.0), (2, 15.0), (4, 10.0), None, (1, 30.0), (9, 6.0)],
        [(4, 10.0), (9, 6.0)],
    ),
    3: (  # one that equals the last target
        "1:4|0.0e+00",
        [None, (1, 30.0), (2, 1.1e-8)],
        [None, (1, 30.0), (2, 1.1e-8), (4, 1e-8)],
        [(4, 1e-8)],
    ),
    5: (  # rows of the .dat file beyond the end
        "1:4|1.2e+01",
        [None, (1, 30.0), (2, 12.0), (6, 9.0), (7, 3.0)],
        [None, (1, 30.0), (2, 12.0), (4, 12.0)],
        [(7, 3.0)],
    ),
}
"""Ends of runs by dimension: the index, the rows of .dat and .tdat (None begins a run), and where the runs end."""


def rows(log):
    """Return the rows of a log of bbob's sphere."""
    header = "% f evaluations | g evaluations | noise-free fitness - Fopt (7.948000000000e+01) | best"
    lines = [f"{row[0]} 0 {row[1]:+.9e} {row[1]:+.9e} {row[1]:+.9e} +0.0e+00" if row else header for row in log]
    return "\n".join([*lines, ""])


@pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads with cocopp and six")
def test_odd_ends_of_runs_are_read_as_cocopp_reads_them(tmp_path):
    folder = tmp_path / "ES"
    (folder / "data_f1").mkdir(parents=True)
    head = "suite = 'bbob', funcId = 1, DIM = {}, Precision = 1.000e-08, algId = 'ES', data_format = 'bbob-new2'\n%\n"
    lines = []
    for dimension, (index, dat, tdat, _) in ODD.items():
        log = f"data_f1/bbobexp_f1_DIM{dimension}"
        lines.append(f"{head.format(dimension)}{log}.dat, {index}\n")
        (folder / f"{log}.dat").write_text(rows(dat))
        (folder / f"{log}.tdat").write_text(rows(tdat))
    (folder / "bbobexp_f1.info").write_text("".join(lines))
    theirs = {each["dimension"]: each for each in read(READ, folder, tmp_path, json.dumps(PRECISIONS.tolist()))}
    found = import_results(folder, tmp_path / "out")
    assert found.notes == ("Runs that go on in the .dat file beyond their end in index and .tdat file: 1.",)
    results = Results(tmp_path / "out")
    for dimension, (*_, ends) in ODD.items():
        name = f"bbob-f01-d{dimension}-i1"
        own, optimum = results.frame[results.frame["problem"] == name], results.facts(name).optimum
        assert own["nfev"].tolist() == theirs[dimension]["spent"] == [evaluations for evaluations, _ in ends]
        np.testing.assert_allclose(own["fun"] - optimum, theirs[dimension]["finals"], rtol=2e-9, atol=1e-13)
        targets = precision_targets([name], PRECISIONS)
        targets["target"] += optimum
        ert = analysis.expected_running_time(analysis.hitting_times(own, results.traces, targets, 100))["ert"]
        np.testing.assert_allclose(ert.astype(float), np.array(theirs[dimension]["ert"], dtype=float), rtol=1e-12)


class TestPartial:
    def test_a_log_that_cannot_be_read_is_left_out_and_listed_where_that_is_asked_for(self, copied, tmp_path):
        (copied / DAT).write_text((copied / DAT).read_text()[:-30])
        refused(copied, tmp_path, "DIM2.dat")
        found = import_results(copied, tmp_path / "out", partial=True)
        (sentence,) = found.left_out
        assert DAT in sentence
        results = Results(tmp_path / "out")
        assert set(results.frame["problem"]) == {f"bbob-f03-d2-i{i}" for i in (1, 2, 3)}
        assert results.environments[0]["left_out"] == [sentence]

    def test_an_index_that_cannot_be_read_is_left_out_with_its_logs(self, copied, tmp_path):
        (copied / "bbobexp_f3.info").write_text("nothing\n")
        assert len(import_results(copied, tmp_path / "out", partial=True).left_out) == 1
        assert set(Results(tmp_path / "out").frame["problem"]) == {f"bbob-f01-d2-i{i}" for i in (1, 2, 3)}

    def test_nothing_that_can_be_read_is_an_error(self, copied, tmp_path):
        for each in copied.glob("*.info"):
            each.write_text("nothing\n")
        with pytest.raises(BenchError, match=r"holds no run that can be read; bbobexp_f1.info, line 1, is no index"):
            import_results(copied, tmp_path / "out", partial=True)
