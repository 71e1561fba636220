"""The comparison matrix and tables, by hand."""

import numpy as np
import pytest

from bench.analysis.cells import summarise
from bench.analysis.matrix import comparison_matrix, medians, table
from bench.analysis.pairwise import pairwise_tests

pytestmark = pytest.mark.filterwarnings("error", "default::ResourceWarning")
INF = float("inf")
LOW = [float(i) for i in range(1, 11)]  # complete separation of ten trials is significant beside 25 tests
NEAR, FAR = [i + 0.05 for i in LOW], [i + 20 for i in LOW]


def row_of(matrix, column, problem="p"):
    return table(matrix, column).loc[problem].tolist()


@pytest.fixture
def matrix_of(frame_of):
    def build(cells, **options):
        frame = frame_of(cells)
        return comparison_matrix(summarise(frame), pairwise_tests(frame), **options)

    return build


class TestMatrix:
    @pytest.mark.parametrize(("statistic", "values"), [("mean", [5.5, 5.55, 25.5]), ("median", [5.5, 5.55, 25.5])])
    def test_bold_is_the_lowest_and_italics_what_the_test_cannot_separate_from_it(self, matrix_of, statistic, values):
        matrix = matrix_of({("p", "a"): LOW, ("p", "b"): NEAR, ("p", "c"): FAR}, statistic=statistic)
        assert list(matrix.columns) == ["problem", "optimizer", "value", "best", "alike"]
        assert row_of(matrix, "value") == pytest.approx(values)
        assert row_of(matrix, "best") == [True, False, False]
        assert row_of(matrix, "alike") == [False, True, False]

    def test_a_cell_with_a_failure_has_no_mean_and_no_mark(self, matrix_of):
        cells = {("p", "a"): [1, 2, None], ("p", "b"): [3, 4, 5.0], ("p", "c"): [6, 7, 8.0]}
        matrix = matrix_of(cells, statistic="mean")
        assert np.isnan(row_of(matrix, "value")[0])
        assert row_of(matrix, "best") == [False, True, False]
        assert row_of(matrix, "alike") == [False, False, True]

    def test_optimizers_that_differ_by_rounding_are_all_best(self, matrix_of):
        cells = {("p", "a"): [1.0] * 10, ("p", "b"): [1 + 1e-13] * 10} | {("p", each): FAR for each in "cde"}
        matrix = matrix_of(cells)
        assert row_of(matrix, "best") == [True, True, False, False, False]
        assert not matrix["alike"].any()
        assert row_of(matrix, "value")[1] == 1 + 1e-13


class TestTables:
    def test_medians_are_those_of_complete_problems_with_near_ties_tied(self, frame_of):
        cells = {("q", "b"): [1 + 1e-13], ("q", "a"): [1.0], ("p", "a"): [3.0], ("r", "b"): [None], ("r", "a"): [2.0]}
        wide = medians(summarise(frame_of(cells)))
        assert wide.loc["q"].tolist() == [1.0, 1.0]
        assert wide.loc["r"].tolist() == [INF, 2.0]
        assert "p" not in wide.index
