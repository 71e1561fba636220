"""Reading tables as papers print them: columns and rows of optimizers, separators, headers, text among numbers."""

import pytest

from bench import BenchError
from bench.reproduce.table import PaperTable, read


def table(tmp_path, text, name="table.csv") -> PaperTable:
    (tmp_path / name).write_text(text, encoding="utf-8")
    return read(tmp_path / name)


LONG = "# suite = 'cec2022'\n# runs = 30\nfunction,dimension,optimizer,mean,sd,best\n"


def numbers(cell):
    return {name: printed.value for name, printed in cell.numbers.items()}


def test_a_row_a_cell_with_what_is_the_same_in_all_rows_at_the_top(tmp_path):
    (cell,) = table(tmp_path, f"{LONG}F05,10,jSO,1.50E+02,3.0,140\n").cells
    assert (cell.suite, cell.function, cell.dimension, cell.runs, cell.optimizer) == ("cec2022", "F05", 10, 30, "jSO")
    assert numbers(cell) == {"mean": 150.0, "sd": 3.0, "best": 140.0}
    assert cell.numbers["mean"].unit == 1.0
    assert cell.where == "F05, d = 10, jSO (line 4)"


def test_a_column_an_optimizer_with_mean_and_sd_in_a_cell(tmp_path):
    cells = table(tmp_path, "fid,GWO,PSO\n1,1.2 ± 0.3,4 (0.5)\n2,7,4.10e−3 ± 1e−3≈\n").cells
    assert [(cell.function, cell.optimizer, numbers(cell)) for cell in cells] == [
        ("1", "GWO", {"mean": 1.2, "sd": 0.3}),
        ("1", "PSO", {"mean": 4.0, "sd": 0.5}),
        ("2", "GWO", {"mean": 7.0}),
        ("2", "PSO", {"mean": 4.1e-3, "sd": 1e-3}),
    ]


@pytest.mark.parametrize(
    ("budget", "evaluations"),
    [("60,000", 60_000), ("1e4 * d", 100_000), ("10000D", 100_000), ("2E5", 200_000), ("", None)],
)
def test_budgets_as_papers_print_them(tmp_path, budget, evaluations):
    (cell,) = table(tmp_path, f'function,optimizer,budget,mean\n1,GWO,"{budget}",3\n').cells
    assert cell.evaluations(10) == evaluations


def test_text_among_numbers_is_noted_and_the_rest_is_read(tmp_path):
    found = table(tmp_path, f"{LONG}1,10,GWO,see text,3,\n2,10,GWO,4,n/a,3\n3,ten,GWO,5,inf,1\n")
    assert [numbers(cell) for cell in found.cells] == [
        {"sd": 3.0},
        {"mean": 4.0, "best": 3.0},
        {"mean": 5.0, "best": 1.0},
    ]
    assert found.notes == (
        "f1, d = 10, GWO (line 4): 'see text' as mean is no number",
        "f3, GWO (line 6): 'inf' as sd is no number",
        "f3, GWO (line 6): 'ten' as dimension is no whole number from 1",
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no header"),
        ("a,b\n1,2\n", "no column of functions"),
        ("function,optimizer,mean\n1,GWO,none\n", "no cell with a number"),
        ("# runs = thirty\nfunction,mean\n", "must be TOML"),
        ("# values = 'rank'\nfunction,mean\n", "values must be"),
    ],
)
def test_what_is_no_table_is_refused_in_a_sentence(tmp_path, text, said):
    with pytest.raises(BenchError, match=said):
        table(tmp_path, text)
