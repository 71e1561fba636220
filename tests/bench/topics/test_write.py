"""The whole report, from a study's folder to the page."""

from pathlib import Path

import pytest

from bench.topics import write_report
from tests.bench.report.size import size

PARTS = [
    "Answer", "Can you trust it?", "Every run", "Over the budget", "Cost", "Methods, environment, files",
]  # fmt: skip


def numbered(titles):
    return [f"{number} {title}" for number, title in enumerate(titles, 1)]


@pytest.fixture(scope="module")
def folder(make, drawn, tmp_path_factory):
    """Return the folder of a study that has its report, to be read only."""
    folder = make(tmp_path_factory.mktemp("usual") / "s")
    with drawn():
        write_report(folder)
    return folder


@pytest.fixture(scope="module")
def usual(read, folder):
    """The page of this report."""
    return read(folder / "report.html")


def test_the_sections_stand_in_their_order(usual):
    assert usual.texts("h2") == numbered(PARTS)


def test_a_report_is_no_longer_than_somebody_reads(folder):
    """The thesis's page has at most 2,500 words opened, 9,000 in all, 2 MB and 60 files; this is a smaller study."""
    found = size(folder)
    assert found["opened"] <= 2500
    assert found["words"] <= 9000
    assert found["bytes"] <= 2e6
    assert found["files"] <= 60


def test_every_file_named_on_the_page_exists_and_no_other(usual, folder):
    linked = {href.partition("#")[0] for href in usual.values("href") if not href.startswith("#")}
    assert {"methods.md", "methods.tex", "references.bib"} <= linked
    assert all((folder / href).is_file() for href in linked)
    linked = {href for href in linked if "/" in href}
    written = {str(path.relative_to(folder)) for kind in ("tables", "figures") for path in (folder / kind).iterdir()}
    assert linked == written
    assert {"tables/comparison.csv", "tables/comparison.tex", "figures/every-run.pdf", "tables/trials.csv"} <= written


@pytest.mark.usefixtures("draws")
def test_the_same_results_give_the_same_bytes(folder, tmp_path):
    write_report(folder, output=tmp_path)
    written = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert len(written) > 20
    assert written == {path: (folder / path).read_bytes() for path in written}


@pytest.mark.slow
@pytest.mark.usefixtures("draws")
def test_the_bytes_do_not_depend_on_the_number_of_processes(make, tmp_path):
    folder = make(tmp_path / "s", problems=tuple("pqrstu"))
    contents = []
    for jobs in (1, 2):
        out = tmp_path / str(jobs)
        write_report(folder, output=out, n_jobs=jobs)
        contents.append({path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()})
    assert contents[0] == contents[1]
    assert Path("figures", "every-run.pdf") in contents[0]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "shape",
    [
        {"optimizers": ("a",), "problems": ("p",), "trials": 1},
        {"optimizers": ("a",)},
        {"trials": 1},
        {"skip": [("p", "a"), ("q", "b")]},
        {"skip": [("p", "a"), ("p", "b"), ("p", "c")]},
        {"optimizers": tuple(f"o{i}" for i in range(12)), "problems": ("p",)},
    ],
)
def test_every_partial_study_has_all_parts_too(make, read, tmp_path, shape):
    page = read(write_report(make(tmp_path / "s", **shape)))
    assert page.texts("h2") == numbered(PARTS)


def test_hostile_labels_are_only_text(make, read, tmp_path):
    problems = ("../../x", "<script>alert(1)</script>", "$\\frac{", 'a"b', "p:1/2")
    folder = make(tmp_path / "s", problems=problems, optimizers=("<img src=x onerror=y>", "a&b_%", "{{ 7*7 }}"))
    page = read(write_report(folder))
    assert "img" not in page.tags
    assert page.tags.count("script") == 3  # the page's own, Vega and what it draws
    assert "<script>alert(1)</script>" in page.text
    assert "{{ 7*7 }}" in page.text
    assert {path.name for path in tmp_path.iterdir()} == {"s"}
