"""One table says what a trial's columns are; results, stores and frames have no others."""

import numpy as np

from bench import FunctionProblem, load_optimizer
from bench.trial.columns import COLUMNS, MEASURED, STORED, named, packed
from bench.trial.trial import as_row, measured, search


def test_names_are_unique_and_meanings_are_phrases():
    assert len({column.name for column in COLUMNS}) == len(COLUMNS)
    for column in COLUMNS:
        assert column.meaning, column.name
        assert not column.meaning.endswith(".")


def test_a_result_has_every_measured_column_with_its_type():
    problem = FunctionProblem(lambda x: (x * x).sum(axis=1), [-1.0], [1.0], variables=("a",))
    found = search(problem, load_optimizer("random-search"), 10, 1)
    for column in MEASURED:
        assert type(measured(found)[column.name]) is column.kind
    assert {column.name for column in STORED} - as_row(found, ("a",)).keys() == {
        "environment", "seed", "error", "log", "inputs"
    }  # fmt: skip


def test_every_bit_of_a_point_and_of_its_metrics_is_kept():
    values = [0.1, -0.0, 5e-324, float("inf"), float("nan"), 1e308]
    row = packed({"x": dict(zip("abcdef", values, strict=True)), "metrics": {"größe": 1 / 3}})
    assert row["x"] == np.array(values, "<f8").tobytes()
    assert np.array([*named(row, "x").values()]).tobytes() == row["x"]
    assert named(row, "metrics") == {"größe": 1 / 3}
