"""COCO's data: the archive of 2009 beside cocopp, round trips of our own export, and files that are refused."""

import json
import math
import tarfile
from importlib.util import find_spec

import numpy as np
import pytest

from bench import BenchError, Results, analysis
from bench.formats.importing import import_results
from bench.formats.naming import agrees
from bench.topics.findings import Findings
from tests.bench.formats.made import exported, make, precision_targets, read

READ = """
import contextlib
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cocopp
    cocopp.archiving.official_archives.bbob
    cocopp.genericsettings.warning_level = 0
    targets, found = json.loads(sys.argv[3]), []
    from cocopp import bestalg
    with contextlib.redirect_stdout(sys.stderr):
        best = bestalg.load_reference_algorithm("refalgs/best2009-bbob.tar.gz", force=True)
    by_length = cocopp.pproc.RunlengthBasedTargetValues(
        [0.5, 1.2, 3, 10, 50], reference_data=best, force_different_targets_factor=10**-0.2
    )
    for data in cocopp.pproc.DataSetList(sys.argv[1]):
        found.append({
            "function": data.funcId, "dimension": data.dim, "ert": data.detERT(targets),
            "spent": data.maxevals.tolist(), "finals": data.finalfunvals.tolist(),
        })
        if data.funcId <= 24:  # the reference has no noisy functions
            found[-1]["by_length"] = data.detERT(by_length((data.funcId, data.dim)))
print("\\n" + json.dumps(found))
"""
PRECISIONS = np.power(10, np.arange(10, -41, -1) / 5)  # COCO's: five a decade from 1e2 to 1e-8
needs_cocopp = pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads with cocopp and six")


@pytest.fixture(scope="module")
def both(archived, imported, tmp_path_factory):
    """The imported results, and what cocopp finds in the same archive, by problem."""
    place = tmp_path_factory.mktemp("cocopp")
    with tarfile.open(archived) as archive:
        archive.extractall(place, filter="data")
    found = read(READ, place / "DIRECT", place, json.dumps(PRECISIONS.tolist()))
    return Results(imported), {f"bbob-f{data['function']:02d}-d{data['dimension']}": data for data in found}


@needs_cocopp
class TestArchive:
    @pytest.mark.slow
    def test_every_run_is_imported_with_its_evaluations(self, both):
        results, found = both
        assert len(results.frame) == sum(len(data["spent"]) for data in found.values()) == 720
        for problem, data in found.items():
            own = results.frame[results.frame["problem"].str.startswith(f"{problem}-i")]
            # of a run that reached 1e-8, cocopp counts the evaluations of the .dat file, which ends there
            solved = own["fun"] - own["problem"].map(lambda label: results.facts(label).optimum) <= 1e-8
            assert own["nfev"][~solved].tolist() == np.array(data["spent"])[~solved].tolist()
            assert (own["nfev"][solved] >= np.array(data["spent"])[solved]).all()

    def test_expected_running_times_are_those_of_cocopp(self, both):
        results, found = both
        findings, reached = Findings(results), 0
        targets = precision_targets(found, PRECISIONS)
        hits = analysis.hitting_times(findings.trials.frame, findings.trials.traces, targets, findings.trials.allowed)
        table = analysis.expected_running_time(hits).set_index(["problem", "tau"])["ert"]
        for problem, data in found.items():
            for precision, ert in zip(PRECISIONS, data["ert"], strict=True):
                mine = table[problem, precision]
                assert mine == pytest.approx(ert if ert is not None else math.inf, rel=1e-12), (problem, precision)
                reached += np.isfinite(mine)
        assert reached > 3000

    def test_expected_running_times_to_targets_by_running_length_are_those_of_cocopp(self, both):
        results, found = both
        table = Findings(results, "runlength").anytime.running_times
        for problem, data in found.items():
            own = table[table["problem"] == problem].sort_values("budget / d", ascending=False)
            assert own["ert"].tolist() == pytest.approx([math.inf if ert is None else ert for ert in data["by_length"]])
        assert len(table) == 5 * len(found)
        assert np.isfinite(table["ert"].astype(float)).sum() > 200

    def test_final_precisions_are_those_of_cocopp(self, both):
        results, found = both
        for problem, data in found.items():
            own = results.frame[results.frame["problem"].str.startswith(f"{problem}-i")]
            optimum = own["problem"].map(lambda label: results.facts(label).optimum)
            np.testing.assert_allclose(own["fun"] - optimum, data["finals"], rtol=1e-9, atol=1e-11)


class TestImported:
    def test_rows_are_marked_and_what_is_unknown_is_missing(self, imported, archived):
        results = Results(imported)
        (record,) = results.environments
        assert record["imported"] == archived.name
        assert record["sha256"] == "5cfe3e57d847a43d2b3e770fa81ffd462fdedfa38d284855f45930c28068f66f"
        assert record["licence"] is None
        assert (results.origins == 1).all()
        assert results.frame[["seed", "wall_s", "cpu_s", "objective_s", "stop", "outside_box"]].isna().all(axis=None)


def round_trip(results, place, kind="coco"):
    import_results(exported(results, kind, place / "out"), place / "back")
    return Results(place / "back")


def unpacked(archived, place, function=1):
    """Return a folder with the data of one function."""
    with tarfile.open(archived) as archive:
        members = [each for each in archive if f"_f{function}." in each.name or f"_f{function}/" in each.name]
        archive.extractall(place, members, filter="data")
    return place / "DIRECT"


def test_our_export_comes_back(tmp_path):
    """Values have ten digits there; labels, evaluations and traces come back as they were."""
    results = make(tmp_path / "s", {"sphere-2": 2, "other": 7})
    back = round_trip(results, tmp_path)
    for name in ("problem", "optimizer", "trial", "nfev"):
        assert back.frame[name].tolist() == results.frame[name].tolist()
    np.testing.assert_allclose(back.frame["fun"], results.frame["fun"], rtol=1e-8, atol=2e-12)
    assert back.traces.keys() == results.traces.keys()
    for key, trace in results.traces.items():
        assert back.traces[key].evaluations.tolist() == trace.evaluations.tolist()
        np.testing.assert_allclose(back.traces[key].values, trace.values, rtol=1e-8, atol=2e-12)


def test_our_export_of_bbob_comes_back_to_the_last_digits_of_the_precision(tmp_path):
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    results = make(tmp_path / "s", {"bbob-f01-d2-i1": 2, "bbob-f08-d5-i3": 5})
    shifted = {label: results.facts(label).optimum for label in ("bbob-f01-d2-i1", "bbob-f08-d5-i3")}
    back = round_trip(results, tmp_path)
    optimum = results.frame["problem"].map(shifted)
    expected = np.maximum(results.frame["fun"] - optimum, 1e-12)
    np.testing.assert_allclose(back.frame["fun"] - optimum, expected, rtol=1e-8, atol=1e-13)


@pytest.mark.parametrize(
    ("suite", "observer", "dimension"),
    [
        ("bbob", "bbob", 5),
        ("bbob-constrained", "bbob-constrained", 2),
        ("bbob-mixint", "bbob-mixint", 10),
        ("bbob-largescale", "bbob-largescale", 20),
        ("bbob-boxed", "bbob", 2),
    ],
)
def test_what_coco_s_own_observer_logs_today_is_imported(tmp_path, monkeypatch, suite, observer, dimension):
    cocoex = pytest.importorskip("cocoex", reason="COCO's own logger is the source")
    monkeypatch.chdir(tmp_path)
    rng, best = np.random.default_rng(0), {}
    logger = cocoex.Observer(observer, "result_folder: logged algorithm_name: random")
    for problem in cocoex.Suite(suite, "instances: 1-2", f"dimensions: {dimension} function_indices: 2,10"):
        problem.observe_with(logger)
        values = []
        for draw in range(50):
            x = rng.uniform(problem.lower_bounds, problem.upper_bounds) if draw else problem.initial_solution
            x[: problem.number_of_integer_variables] = np.round(x[: problem.number_of_integer_variables])
            if not problem.number_of_constraints or (problem.constraint(x) <= 0).all():
                values.append(problem(x))
        best[f"{suite}-f{problem.id_function:02d}-d{dimension}-i{problem.id_instance}"] = min(values), len(values)
        problem.free()
    import_results(tmp_path / "exdata" / "logged", tmp_path / "back")
    frame = Results(tmp_path / "back").frame.set_index("problem")
    assert [*frame.index] == [*best]
    assert frame["nfev"].tolist() == [evaluations for _, evaluations in best.values()]
    np.testing.assert_allclose(frame["fun"], [value for value, _ in best.values()], rtol=1e-9)


def change(file, old, new):
    content = file.read_bytes()
    assert old in content
    file.write_bytes(content.replace(old, new, 1))


LOG, TIMED = "data_f1/bbobexp_f1_DIM2.dat", "data_f1/bbobexp_f1_DIM2.tdat"
ROW = b"10 +9.507185778e-002 +9.507185778e-002 +7.957507186e+001 +7.957507186e+001 +0.0000e+000 -1.3333e+000"


class TestRefused:
    @pytest.mark.parametrize(
        ("file", "old", "new", "sentence"),
        [
            (LOG, ROW, b"x 1 2 3", r"bbobexp_f1_DIM2.dat, line 3, has 'x … 2', no numbers"),
            (LOG, ROW, b"10", r"bbobexp_f1_DIM2.dat, line 3, is cut short: '10'"),
            (LOG, ROW, ROW.replace(b"10 ", b"50 ", 1), r"line 4, has evaluation 44 after evaluation 50"),
            (LOG, ROW, ROW.replace(b"10 ", b"1 ", 1), r"line 3, repeats evaluation 1 with another value"),
            (LOG, b"(7.948000000000e+001)", b"(7.949000000000e+001)", r"whose optimum is 79.48 here"),
            (LOG, b"Fopt (7.948000000000e+001)", b"nothing", r"line 1, is the header of a run without its f_opt"),
            ("bbobexp_f1.info", b", 5:495|-4.8e-009", b"", r"begins a run that no index names"),
            ("bbobexp_f1.info", b"-4.8e-009", b"-4.8e-009, 6:3|1", r"ends before the run on instance 6"),
            ("bbobexp_f1.info", b"funcId = 1", b"funcId = one", r"line 1, has no number of the function or dimension"),
            ("bbobexp_f1.info", b"data_f1\\bbobexp_f1_DIM2", b"..\\..\\etc", r"line 3, names .*which is outside the"),
            ("bbobexp_f1.info", b"funcId = 1", b"suite = 'bbob-biobj', funcId = 1", r"of bi-objective results"),
        ],
    )
    def test_a_broken_file_is_named_with_its_line_and_nothing_is_imported(
        self, archived, tmp_path, file, old, new, sentence
    ):
        pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
        folder = unpacked(archived, tmp_path)
        change(folder / file, old, new)
        with pytest.raises(BenchError, match=sentence):
            import_results(folder, tmp_path / "out")
        assert {each.name for each in tmp_path.iterdir()} == {"DIRECT"}

    def test_logs_that_end_before_the_final_value_of_the_index_are_refused(self, archived, tmp_path):
        folder = unpacked(archived, tmp_path)
        for file in (LOG, TIMED):
            lines = (folder / file).read_bytes().splitlines(keepends=True)
            (folder / file).write_bytes(b"".join(lines[:-24] if file == TIMED else lines[:-12]))
        with pytest.raises(BenchError, match="its run on instance 5 ends at evaluation"):
            import_results(folder, tmp_path / "out")


def test_what_old_archives_have_is_read(archived, tmp_path):
    """A comma at the end of a line, a last line without an end, files of macOS, a value that is no number."""
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")
    folder = unpacked(archived, tmp_path)
    import_results(folder, tmp_path / "whole")
    change(folder / "bbobexp_f1.info", b", 5:495|-4.8e-009", b", 5:495|-4.8e-009,")
    (folder / LOG).write_bytes((folder / LOG).read_bytes().rstrip())
    change(folder / TIMED, b"1 +1.402094080e+000 +1.402094080e+000", b"1 nan nan")
    (folder / "._bbobexp_f1.info").write_bytes(b"Mac OS X")
    import_results(folder, tmp_path / "old")
    old, whole = (Results(tmp_path / name).frame.drop(columns="study") for name in ("old", "whole"))
    assert old.equals(whole)


def test_parts_of_an_experiment_are_one_optimizer_and_experiments_that_share_a_name_are_not(archived, tmp_path):
    for name, function in (("part-1", 1), ("part-2", 2), ("twice", 2)):
        unpacked(archived, tmp_path / "all" / name, function).rename(tmp_path / "all" / name / f"x-{name}")
    (tmp_path / "all" / "twice").rename(tmp_path / "twice")
    import_results(tmp_path / "all", tmp_path / "one")
    assert set(Results(tmp_path / "one").frame["optimizer"]) == {"DIRECT"}
    (tmp_path / "twice").rename(tmp_path / "all" / "twice")
    import_results(tmp_path / "all", tmp_path / "several")
    assert set(Results(tmp_path / "several").frame["optimizer"]) == {"x-part-1", "x-part-2", "x-twice"}


@pytest.mark.parametrize(
    ("printed", "value", "same"),
    [("7.948000000e+01", 79.48, True), ("7.948e1", 79.4846, True), ("7.948e+001", 79.5, False), ("-0", 0.0, True)],
)
def test_a_printed_value_agrees_to_its_last_digit(printed, value, same):
    assert agrees(printed, value) is same
