"""Plain tables: what they hold comes back, and what cannot be read is named with its line."""

import numpy as np
import pandas as pd
import pytest

from bench import BenchError, Results
from bench.formats.importing import import_results
from bench.topics.course import section as course
from bench.topics.findings import Findings
from tests.bench.formats.made import exported, make, some_fail

TABLE = """optimizer,problem,trial,evaluations,value
pso,p,0,1,9.5
de,p,0,3,4
pso,p,0,7,2.25
pso,p,0,20,3
pso,q,1,5,1e-3
"""


def written(folder, text=TABLE):
    file = folder / "runs.csv"
    file.write_text(text)
    return file


def test_a_table_of_evaluations_becomes_trials(tmp_path):
    import_results(written(tmp_path), tmp_path / "out", licence="CC-BY-4.0")
    results = Results(tmp_path / "out")
    frame = results.frame[["problem", "optimizer", "trial", "fun", "nfev"]]
    assert frame.to_numpy().tolist() == [["p", "pso", 0, 2.25, 20], ["p", "de", 0, 4.0, 3], ["q", "pso", 1, 0.001, 5]]
    assert results.traces["p", "pso", 0].evaluations.tolist() == [1, 7]
    assert results.environments[0]["licence"] == "CC-BY-4.0"


def test_problems_of_unknown_dimension_have_their_curves_over_evaluations(tmp_path):
    import_results(written(tmp_path), tmp_path / "out")
    findings = Findings(Results(tmp_path / "out"))
    together = next(item for item in course.section(findings).items if item.name == "targets-reached")
    assert findings.trials.dimensions == {}
    assert together.data["evaluations"].max() == 20


def test_our_export_comes_back_with_failures_and_times(tmp_path):
    results = make(tmp_path / "s", {"sphere-2": 2, "p": 3, "never": 2}, row=some_fail)
    import_results(exported(results, "csv", tmp_path / "out"), tmp_path / "back")
    back = Results(tmp_path / "back")
    before, after = (each.frame.drop(columns=["study", "error"]) for each in (results, back))
    pd.testing.assert_frame_equal(after, before, check_dtype=False, check_exact=True)
    assert (
        back.frame["error"].str.replace("\r\n", "\n").tolist()[1:3]
        == ['ValueError: boom, "really"\n\tTraceback\nmore'] * 2
    )
    assert back.traces.keys() == results.traces.keys()
    assert all(np.array_equal(back.traces[key].values, each.values) for key, each in results.traces.items())


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("7,2.25", "1,2.25", "line 4, has evaluation 1 after evaluation 1"),
        ("20,3", "5,3", "line 5, has evaluation 5 after evaluation 7"),
        ("1,9.5", "0,9.5", "line 2, has evaluation 0 where a run begins"),
        ("7,2.25", "7.5,2.25", "line 4, has '7.5' as evaluations, which is no whole number"),
        ("7,2.25", "7,", "line 4, has no value"),
        ("7,2.25", "7,-inf", "line 4, has the value -inf"),
        ("7,2.25", "7,-1e999", "line 4, has the value -inf"),
        ("7,2.25", "7,nan", "line 4, has no value"),
        ("5,1e-3", f"{10**15 - 1}1,1e-3", "line 6, has '9999999999999991' as evaluations, which is no whole number"),
        ("q,1,", f"q,{10**6},", "has trial 1000000, which must be from 0 to 999999"),
        ("7,2.25", "7,two", "has a value that is no number: could not convert string to float: 'two'"),
        ("de,p", "de, ", "has a name that is empty"),
        ("5,1e-3\n", "5,1e-3", "is cut short: its last line has no end"),
        ("5,1e-3\n", "5\n", "line 6, has no value"),
    ],
)
def test_what_is_broken_is_named_and_nothing_is_imported(tmp_path, old, new, sentence):
    file = written(tmp_path, TABLE.replace(old, new))
    with pytest.raises(BenchError, match=sentence):
        import_results(file, tmp_path / "out")
    assert [each.name for each in tmp_path.iterdir()] == ["runs.csv"]
