"""One study of several that are compared; readers of such a study are in tests/bench/formats/test_beside.py."""

import pytest

from bench import BenchError, Results, Study, run
from bench.results.union import united

CODE = """
import bench
class Shape(bench.FunctionProblem):
    def __init__(self):
        super().__init__(lambda x: (x**2).sum(axis=1), [-1.0] * 3, [1.0] * 3)
"""


def study(name, optimizer, budget, problem="shape.py:Shape"):
    problems, optimizers = [{"name": problem, "label": "shape"}], [{"name": optimizer}]
    return Study.from_dict(
        {"name": name, "trials": 1, "budget": budget, "problems": problems, "optimizers": optimizers}
    )


HERE, BROUGHT = study("here", "random-search", "20 * d"), study("brought", "imported:theirs", {"3": 500})


def test_the_dimension_of_a_problem_in_a_file_is_that_of_its_stored_trials():
    assert united([HERE, BROUGHT], ["here", "brought"], {"shape": 3}.get).budget == {"3": 500}


def test_a_problem_in_a_file_without_finished_trials_is_not_loaded_for_its_dimension():
    with pytest.raises(BenchError, match="'shape' is not known: no folder holds a finished trial on it"):
        united([HERE, BROUGHT], ["here", "brought"], {}.get)


def test_no_file_of_a_folder_is_loaded_where_it_is_compared(tmp_path):
    (tmp_path / "shape.py").write_text(CODE)
    run(study("here", "random-search", "20 * d", f"{tmp_path}/shape.py:Shape"), tmp_path / "here", n_jobs=1)
    (tmp_path / "shape.py").write_text("raise SystemExit('loaded')")
    (tmp_path / "brought").mkdir()
    (tmp_path / "brought" / "study.toml").write_text(BROUGHT.to_toml())
    assert Results(tmp_path / "here", tmp_path / "brought").study.budget == {"3": 500}
