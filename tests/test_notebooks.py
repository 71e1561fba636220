"""The example notebooks are stored with outputs, run from top to bottom, and show what they promise."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "notebooks"
NAMES = ("first-comparison", "read-a-store", "from-a-function")  # the second reads what the first one writes


def read(name):
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_stored_with_the_outputs_of_one_run(name):
    code = [cell for cell in read(name).cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert sum(bool(cell.outputs) for cell in code) > 3
    assert not any(output.output_type == "error" for cell in code for output in cell.outputs)


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """The outputs of every notebook as one text of HTML, and the number of its pictures."""
    place, found = tmp_path_factory.mktemp("notebooks"), {}
    for name in NAMES:
        notebook = read(name)
        NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(place)}}).execute()
        outputs = [each.get("data", {}) for cell in notebook.cells for each in cell.get("outputs", ())]
        pages = "".join(each.get("text/html", "") for each in outputs)
        found[name] = pages, sum("image/png" in each for each in outputs)
    assert (place / "comparison.pdf").stat().st_size > 0
    return found


@pytest.mark.slow
def test_the_notebooks_show_tables_progress_and_figures(shown):
    page, pictures = shown["first-comparison"]
    for part in ("Result of one run", "Study first", "runs done", "Results of study first", "keeps the contract"):
        assert part in page
    assert pictures == 1
    page, pictures = shown["read-a-store"]
    assert "Results of study first" in page
    assert pictures == 2


@pytest.mark.slow
def test_two_cells_go_from_a_function_to_a_verdict(shown):
    code = [cell for cell in read("from-a-function").cells if cell.cell_type == "code"]
    assert "lambda x:" in code[0].source
    assert not code[0].outputs
    assert "bench.compare(" in code[1].source
    first = code[1].outputs[-1]["data"]["text/html"]
    page, pictures = shown["from-a-function"]
    for part in ("cma-es ends lowest on", "chance", "Results of study comparison"):
        assert part in first
        assert part in page
    assert pictures == 1
