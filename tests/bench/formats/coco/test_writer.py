"""The coco format, read back with the real cocopp in a process of its own."""

import json
import math
from importlib.util import find_spec

import numpy as np
import pytest

import bench
from bench import BenchError, Results, analysis
from bench.analysis.running_time import running_times
from bench.formats.coco import writer as coco
from bench.formats.exporting import export
from bench.results.results import ProblemFacts
from bench.study import Entry, Study
from bench.study.targets import COCO_PRECISIONS
from tests.bench.formats.made import HOSTILE, exported, make, read, record, some_fail
from tests.bench.made import Known

READ_COCO = """
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cocopp
    cocopp.archiving.official_archives.bbob
warnings.simplefilter("error")
cocopp.genericsettings.warning_level = 0
targets, found = json.loads(sys.argv[3]), []
for name in sorted(os.listdir(sys.argv[1])):
    if os.path.isdir(folder := os.path.join(sys.argv[1], name)):
        for data in cocopp.pproc.DataSetList(folder):
            found.append({
                "function": data.funcId, "dimension": data.dim, "folder": name, "algorithm": data.algId,
                "spent": data.maxevals.tolist(), "finals": data.finalfunvals.tolist(), "ert": data.detERT(targets),
            })
print("\\n" + json.dumps(found))
"""
READ_SUITES = """
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import cocopp
    cocopp.archiving.official_archives.bbob
warnings.simplefilter("error")
for remark in ("  less than 15 instances", "  instance numbers not among", ".* was not consistent"):
    warnings.filterwarnings("ignore", remark)  # a small experiment is meant
cocopp.genericsettings.warning_level = 0
settings, found = cocopp.testbedsettings, []
targets, folders = json.loads(sys.argv[3])
for name in folders:
    settings.reset_current_testbed()
    for data in cocopp.pproc.DataSetList(os.path.join(sys.argv[1], name)):
        found.append({
            "folder": name, "suite": data.suite, "function": data.funcId, "dimension": data.dim,
            "instances": data.instancenumbers, "ert": data.detERT(targets),
            "evaluations": [row.tolist() for row in data.detEvals(targets)],
        })
known = {}
for suite in settings.suite_to_testbed:
    settings.reset_current_testbed()
    settings.load_current_testbed(suite, cocopp.pproc.TargetValues)
    known[suite] = [getattr(settings.current_testbed, end + "_function_number") for end in ("first", "last")]
print("\\n" + json.dumps({"sets": found, "known": known}))
"""
TARGETS = [100.0, 1.0, 0.1, 1e-3]
PRECISIONS = COCO_PRECISIONS.tolist()
FACTS = "optimum", "features"
KEYS = "suite", "function"
TRIGGERS = sorted({math.floor(10 ** (i / 20) + 1e-9) for i in range(62)})  # to 1122
needs_cocopp = pytest.mark.skipif(
    not (find_spec("cocopp") and find_spec("six")), reason="reads the coco format with cocopp and six"
)


@pytest.fixture(scope="module")
def coco_read(tmp_path_factory):
    place = tmp_path_factory.mktemp("coco")
    results = make(place / "s", {"sphere-2": 2, "../../p": 7, "never": 2}, (*HOSTILE, "a"), row=some_fail)
    folder = exported(results, "coco", place / "out")
    return results, read(READ_COCO, folder, place, json.dumps(TARGETS))


@needs_cocopp
class TestCOCO:
    @staticmethod
    def traces(results, data):
        problem = results.study.problems[data["function"] - 1].label
        folders = {folder: label for label, folder in coco.optimizer_folders(results).items()}
        here = results.frame.query("problem == @problem and status == 'ok'", engine="python")
        here = here[here["optimizer"] == folders[data["folder"]]]
        return problem, [(results.traces[problem, row.optimizer, row.trial], row) for row in here.itertuples()]

    def test_every_cell_and_trial_is_found(self, coco_read):
        results, found = coco_read
        assert len(found) == 3 * len(results.study.optimizers)
        assert len({data["algorithm"] for data in found}) == len(results.study.optimizers)
        for data in found:
            _, runs = self.traces(results, data)
            assert data["spent"] == [row.nfev for _, row in runs]
            assert data["dimension"] == (2, 7, 2)[data["function"] - 1]

    def test_values_and_expected_running_times_agree(self, coco_read):
        results, found = coco_read
        references, reached = coco.assumed_optima(results), 0
        for data in found:
            problem, runs = self.traces(results, data)
            reference = references[problem].value
            finals = [min(max(row.fun - reference, 1e-12), 3e21) for _, row in runs]
            np.testing.assert_allclose(data["finals"], finals, rtol=1e-9)
            for target, ert in zip(TARGETS, data["ert"], strict=True):
                hits = [trace.evaluations[trace.values - reference <= target] for trace, _ in runs]
                spent = sum(hit[0] if len(hit) else row.nfev for hit, (_, row) in zip(hits, runs, strict=True))
                successes = sum(len(hit) > 0 for hit in hits)
                assert ert == pytest.approx(spent / successes if successes else math.inf)
                reached += successes
        assert reached > 100


def entries(*names):
    return tuple(Entry(name, name) for name in names)


@pytest.fixture(scope="module")
def bbob_read(tmp_path_factory):
    """A run on bbob, read by cocopp: f1 and f15 in two dimensions on five instances, two trials each."""
    place = tmp_path_factory.mktemp("suites")
    problems = [f"bbob-f{f:02d}-d{d}-i{i}" for f in (1, 15) for d in (5, 2) for i in (3, 1, 2, 5, 4)]
    optimizers = entries("cma-es", "random-search")
    bench.run(Study("s", entries(*problems), optimizers, trials=2, budget="200 * d"), place / "s")
    results = Results(place / "s")
    folder, names = exported(results, "coco", place / "out"), list(coco.optimizer_folders(results).values())
    return results, read(READ_SUITES, folder, place, json.dumps([PRECISIONS, names]))


@needs_cocopp
class TestSuites:
    """Problems of COCO's own suites."""

    @pytest.mark.slow
    def test_functions_dimensions_and_instances_are_coco_s(self, bbob_read):
        found = {(data["folder"], data["suite"], data["function"], data["dimension"]) for data in bbob_read[1]["sets"]}
        assert found == {(name, "bbob", f, d) for name in ("cma-es", "random-search") for f in (1, 15) for d in (2, 5)}
        assert len(bbob_read[1]["sets"]) == len(found)
        assert all(data["instances"] == [1, 1, 2, 2, 3, 3, 4, 4, 5, 5] for data in bbob_read[1]["sets"])

    @pytest.mark.slow
    def test_expected_running_times_are_those_of_the_analysis(self, bbob_read):
        results, found = bbob_read
        labels = [entry.label for entry in results.study.problems]
        facts = {label: results.facts(label) for label in labels}
        optima, features = ({label: getattr(each, name) for label, each in facts.items()} for name in FACTS)
        pooled = analysis.pool_instances(results.frame, results.traces, labels, features, optima)
        targets = analysis.target_table("precisions", pooled.frame, pooled.traces, dict.fromkeys(pooled.functions, 0.0))
        assert targets["tau"].unique().tolist() == PRECISIONS
        budgets = {label: 200 * int(label.split("-d")[1]) for label in pooled.members}
        hits = analysis.hitting_times(pooled.frame, pooled.traces, targets, budgets)
        ert = running_times(hits).set_index(["problem", "optimizer", "tau"])["ert"]
        reached = set()
        for data in found["sets"]:
            problem = f"bbob-f{data['function']:02d}-d{data['dimension']}"
            for tau, theirs in zip(PRECISIONS, data["ert"], strict=True):
                assert theirs == ert[problem, data["folder"], tau]
                reached |= {theirs}
        assert len(reached) > 100
        assert math.inf in reached

    @pytest.mark.slow  # as are all tests that need this study in cocopp
    def test_the_suites_have_the_functions_that_cocopp_knows(self, bbob_read):
        for suite, functions in coco.SUITES.items():
            assert bbob_read[1]["known"][suite] == [functions[0], functions[-1]]

    @pytest.mark.slow
    def test_a_study_of_several_suites_has_a_folder_for_each(self, tmp_path):
        numbers = {"bbob": 24, "bbob-boxed": 3, "bbob-largescale": 7, "bbob-mixint": 9, "bbob-noisy": 130}
        labels = [f"{suite}-f{number:02d}-d20-i{i}" for suite, number in numbers.items() for i in (2, 1)]
        make(tmp_path / "s", dict.fromkeys([*labels, "home"], 20), ("a",), trials=1)
        features = {label: dict(zip(KEYS, label.rsplit("-", 3)[:2], strict=True)) for label in labels}
        facts = {
            label: ProblemFacts(optimum=-5.0, features=each | {"instance": int(label[-1])})
            for label, each in features.items()
        }
        results = Known(tmp_path / "s", lambda label: facts.get(label, ProblemFacts()))
        folder = exported(results, "coco", tmp_path / "out")
        folders = [f"{suite}/a" for suite in numbers]
        found = read(READ_SUITES, folder, tmp_path, json.dumps([PRECISIONS, folders]))["sets"]
        assert [(data["folder"], data["suite"], data["function"]) for data in found] == [
            (f"{suite}/a", suite, number) for suite, number in numbers.items()
        ]
        assert all(data["instances"] == [1, 2] for data in found)
        assert (folder / "other-problems" / "a" / "bbobexp_f1.info").is_file()
        about = (folder / "README.txt").read_text()
        assert "FOLDER/SUITE/OPTIMIZER" in about
        assert "    bbob-mixint  functions 9\n    bbob-noisy  functions 130\n" in about
        assert "    1  home: " in about
        assert "of the constraints" not in about

    @pytest.mark.slow
    def test_an_evaluation_of_a_constrained_function_counts_twice_as_in_coco(self, tmp_path):
        row = lambda *_: record([math.inf, 9.0, 5.5, 5.0], 2)  # noqa: E731
        make(tmp_path / "s", {"bbob-constrained-f54-d2-i1": 2}, ("a",), trials=1, row=row)
        features = {"suite": "bbob-constrained", "function": "f54", "instance": 1}
        results = Known(tmp_path / "s", lambda label: ProblemFacts(optimum=5.0, features=features))
        folder = exported(results, "coco", tmp_path / "out")
        (data,) = read(READ_SUITES, folder, tmp_path, json.dumps([[10.0, 1.0, 1e-8], ["a"]]))["sets"]
        assert data["evaluations"] == [[4.0], [6.0], [8.0]]
        assert "counts as one of the objective and one of the constraints" in (folder / "README.txt").read_text()


class TestCOCOFiles:
    def test_a_problem_is_a_suite_s_own_only_with_all_that_coco_counts_by(self):
        features = {"suite": "bbob", "function": "f24", "instance": 7}
        assert coco.own_place(ProblemFacts(optimum=0.0, features=features)) == ("bbob", 24, 7, True)
        for change in ({"suite": "cec2022"}, {"function": "f25"}, {"function": "sphere"}, {"instance": "1"}):
            assert coco.own_place(ProblemFacts(optimum=0.0, features=features | change)) is None
        assert coco.own_place(ProblemFacts(features=features)) is None

    def test_the_f_opt_of_a_suite_stays_where_a_trial_is_below_it(self, tmp_path):
        results = make(tmp_path / "s", {"bbob-f01-d2-i1": 2}, row=lambda *_: record([80.0, 79.0], 2))
        assert coco.assumed_optima(results)["bbob-f01-d2-i1"].value == results.facts("bbob-f01-d2-i1").optimum > 79

    def test_a_known_optimum_is_the_reference_unless_a_trial_is_below_it(self, tmp_path):
        below = make(tmp_path / "b", row=lambda trial, values: record([3.0, -1.0], 2) if trial.number == 0 else None)
        above = make(tmp_path / "a")
        lowest = above.frame.groupby("problem")["fun"].min().to_dict()
        assert coco.assumed_optima(above)["sphere-2"] == coco.AssumedOptimum(0.0, "the problem's best known value")
        assert coco.assumed_optima(above)["p"] == coco.AssumedOptimum(
            lowest["p"], "the lowest value found by any trial"
        )
        assert coco.assumed_optima(below)["sphere-2"].value == -1.0
        readme = (exported(above, "coco", tmp_path / "out") / "README.txt").read_text()
        assert "1  sphere-2: 0.0, the problem's best known value" in readme
        assert f"2  p: {lowest['p']!r}, the lowest value found by any trial" in readme

    def test_the_best_value_of_all_is_written_as_a_positive_difference(self, tmp_path):
        results = make(tmp_path / "s", {"p": 2}, row=lambda trial, values: record([1e10 + 1, 1e10], 2))
        folder = exported(results, "coco", tmp_path / "out")
        paths = sorted(folder.rglob("*dat"))
        assert len(paths) == 4
        for path in paths:
            rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("%")]
            assert {row[2] for row in rows} == {"+1.000000000e+00", "+1.000000000e-12"}

    def test_evaluations_are_triggered_twenty_times_a_decade(self, tmp_path):
        values = np.linspace(2, 1, 1234)
        results = make(tmp_path / "s", trials=1, row=lambda *_: record(values.tolist(), 2))
        folder = exported(results, "coco", tmp_path / "out")
        lines = (folder / "a" / "data_f2" / "bbobexp_f2_DIM2.tdat").read_text().splitlines()[1:]
        expected = [*TRIGGERS, 1234]
        assert [int(line.split()[0]) for line in lines] == expected

    def test_more_problems_than_functions_are_refused(self, tmp_path):
        problems = {f"p{i}": 1 for i in range(55)}
        results = make(tmp_path / "s", problems, ("a",), trials=1)
        with pytest.raises(BenchError, match="not known to be of COCO's own suites, and this study has 55 \\(unknown"):
            export(results, "coco", tmp_path / "out")
        assert not (tmp_path / "out").exists()
