"""Printed names of functions and optimizers mean problems and optimizers of this harness."""

import pytest

from bench.reproduce.names import optimizer_of, problem_of
from bench.reproduce.table import PaperCell, PaperTable

TABLE = PaperTable("t", ())


def cell(suite, function, dimension=10, instance=None):
    return PaperCell(1, suite, function, "GWO", dimension, instance, 30, "", {}, {})


@pytest.mark.parametrize(
    ("suite", "function", "name"),
    [
        ("cec2022", "12", "cec2022-f12-d10"),
        ("CEC 2022", "F05", "cec2022-f05-d10"),
        ("cec-2017", "cec2017_f7", "cec2017-f07-d10"),
        ("CEC2022", "F22-01", "cec2022-f01-d10"),
        ("bbob", "f8", "bbob-f08-d10-i1"),
        ("classical", "Rastrigin", "classical-rastrigin-d10-i1"),
        ("bbob", "Bent Cigar", "bbob-f12-d10-i1"),
        ("signature", "3", "signature-03"),
        ("", "signature-03", "signature-03"),
    ],
)
def test_functions_by_number_or_name(suite, function, name):
    assert problem_of(TABLE, cell(suite, function)) == name


@pytest.mark.parametrize(
    ("printed", "name"),
    [("GWO", "gwo"), ("CMA-ES", "cma-es"), ("jSO", "minion:jSO"), ("mealpy:L_SHADE", "mealpy:L_SHADE")],
)
def test_optimizers_by_their_usual_names(printed, name):
    assert optimizer_of(TABLE, printed) == {"name": name, "label": printed}
