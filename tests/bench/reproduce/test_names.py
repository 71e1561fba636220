"""Printed names of functions and optimizers mean problems and optimizers of this harness."""

import pytest

from bench import BenchError
from bench.reproduce.names import load_problem, optimizer_of, problem_of
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


def test_an_instance_and_a_name_that_the_table_explains():
    assert problem_of(TABLE, cell("bbob", "8", 5, 3)) == "bbob-f08-d5-i3"
    table = PaperTable("t", (), (), {"functions": {"P1": "engineering-welded-beam"}, "problem": {"unit": "rpm"}})
    assert problem_of(table, cell("", "P1")) == "engineering-welded-beam"
    assert load_problem(table, cell("", "signature-03")).name == "signature-03"


@pytest.mark.parametrize(
    ("suite", "function", "dimension", "said"),
    [
        ("cec2021", "1", 10, "no suite is called 'cec2021'; did you mean"),
        ("cec2022", "13", 10, "no function 'f13'; it has f01 to f12"),
        ("cec2022", "1", 7, "no dimension 7"),
        ("cec2022", "1", None, "no dimension is printed"),
        ("classical", "nosuch", 10, "no function 'nosuch'"),
        ("signature", "99", None, "signature has no problem '99'"),
    ],
)
def test_a_function_that_there_is_not_is_one_sentence(suite, function, dimension, said):
    with pytest.raises(BenchError, match=said):
        problem_of(TABLE, cell(suite, function, dimension))


@pytest.mark.parametrize(
    ("printed", "name"),
    [("GWO", "gwo"), ("CMA-ES", "cma-es"), ("jSO", "minion:jSO"), ("mealpy:L_SHADE", "mealpy:L_SHADE")],
)
def test_optimizers_by_their_usual_names(printed, name):
    assert optimizer_of(TABLE, printed) == {"name": name, "label": printed}


def test_an_optimizer_that_the_table_explains():
    table = PaperTable("t", (), (), {"optimizers": {"A": {"name": "gwo", "agents": 30}, "B": "cma-es"}})
    assert optimizer_of(table, "A") == {"name": "gwo", "label": "A", "agents": 30}
    assert optimizer_of(table, "B") == {"name": "cma-es", "label": "B"}


def test_an_optimizer_that_there_is_not_is_one_sentence():
    with pytest.raises(BenchError, match="no optimizer is called 'HAALO'; name one with --optimizer 'HAALO=NAME'"):
        optimizer_of(TABLE, "HAALO")


def test_a_name_that_several_implementations_have_is_one_sentence():
    with pytest.raises(BenchError, match="'L-SHADE' may be mealpy:L_SHADE or minion:LSHADE; name one with --optimizer"):
        optimizer_of(TABLE, "L-SHADE")
