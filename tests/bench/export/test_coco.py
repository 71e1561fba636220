"""The coco format, read back with the real cocopp in a process of its own."""

import json
import math
from importlib.util import find_spec

import numpy as np
import pytest

from bench import BenchError
from bench.export import coco, export
from tests.bench.export.made import HOSTILE, exported, make, read, record, some_fail

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
                "funvals": data.funvals.tolist(),
            })
last = cocopp.testbedsettings.CONSBBOBTestbed.settings["last_function_number"]
print("\\n" + json.dumps({"sets": found, "last": last}))
"""
TARGETS = [100.0, 1.0, 0.1, 1e-3]
TRIGGERS = sorted({math.floor(10 ** (i / 20) + 1e-9) for i in range(62)})  # to 1122


@pytest.fixture(scope="module")
def coco_read(tmp_path_factory):
    place = tmp_path_factory.mktemp("coco")
    results = make(place / "s", {"sphere-2": 2, "../../p": 7, "never": 2}, (*HOSTILE, "a"), row=some_fail)
    folder = exported(results, "coco", place / "out")
    return results, read(READ_COCO, folder, place, json.dumps(TARGETS))


@pytest.mark.skipif(not (find_spec("cocopp") and find_spec("six")), reason="reads the coco format with cocopp and six")
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
        assert len(found["sets"]) == 3 * len(results.study.optimizers)
        assert len({data["algorithm"] for data in found["sets"]}) == len(results.study.optimizers)
        for data in found["sets"]:
            _, runs = self.traces(results, data)
            assert data["spent"] == [row.nfev for _, row in runs]
            assert data["dimension"] == (2, 7, 2)[data["function"] - 1]

    def test_values_and_expected_running_times_agree(self, coco_read):
        results, found = coco_read
        references, reached = coco.assumed_optima(results), 0
        for data in found["sets"]:
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

    def test_values_at_the_triggered_evaluations_agree(self, coco_read):
        results, found = coco_read
        references, compared = coco.assumed_optima(results), 0
        for data in found["sets"]:
            problem, runs = self.traces(results, data)
            evaluations, *columns = np.array(data["funvals"]).T
            for (trace, row), column in zip(runs, columns, strict=True):
                triggered = np.isin(evaluations, [*TRIGGERS, row.nfev]) & (evaluations <= row.nfev)
                expected = np.clip(trace.at(evaluations) - references[problem].value, 1e-12, 3e21)
                np.testing.assert_allclose(column[triggered], expected[triggered], rtol=1e-9)
                compared += triggered.sum()
        assert compared > 1000

    def test_the_suite_has_as_many_functions_as_cocopp_knows(self, coco_read):
        assert coco_read[1]["last"] == coco.FUNCTIONS


class TestCOCOFiles:
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
        with pytest.raises(BenchError, match="at most 54 problems and this study has 55"):
            export(results, "coco", tmp_path / "out")
        assert not (tmp_path / "out").exists()
