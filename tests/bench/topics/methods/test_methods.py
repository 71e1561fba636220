"""The methods: at most 250 words that follow from the facts, in three formats, and every citation has its work."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench import Results
from bench.helpers.bibtex import parse, read
from bench.plugins import registry
from bench.report.latex import prose
from bench.study import Entry, Study
from bench.study.descriptions import Description
from bench.topics.findings import Findings
from bench.topics.methods import methods as module
from bench.topics.methods import section
from bench.topics.methods.methods import bibliography, machine, methods, parameters

ENVIRONMENT = {
    "python": "3.11.7", "packages": {"backlash-bench": "0.1.0", "numpy": "2.4.6", "scipy": "1.17.1", "pandas": "3.1"},
    "processor": "A & B processor",
}  # fmt: skip
HOSTILE = "50% of_$wölves$ & #1 {~^\\} [@a]"
LATEX = shutil.which("pdflatex") and shutil.which("bibtex")


def study(*optimizers):
    return Study("s", (Entry("p", "p"),), tuple(optimizers))


@pytest.fixture(scope="module")
def found(make, tmp_path_factory):
    """Return the methods of a study in which much can be said: hostile names, options, a failed trial, a short one."""
    labels = ("gwo", "alo", "cma-es", HOSTILE)
    folder = make(
        tmp_path_factory.mktemp("methods") / "s", ("p", "q"), labels, trials=20, fail=[("p", "alo", 1)],
        options={"gwo": {"agents": 7}}, changes={"cma-es": {"stop": "tolfun", "nfev": 50}}, record=ENVIRONMENT,
    )  # fmt: skip
    findings = Findings(Results(folder))
    described = {label: Description(registry.load("optimizers", label).bibtex) for label in labels[:3]}
    findings.__dict__["descriptions"] = described
    return methods(findings)


def test_every_sentence_follows_from_the_study(found):
    for said in (
        "We ran 4 optimizers on 2 problems (p and q)", "gwo (Mirjalili et al., 2014), alo (Mirjalili, 2015), cma-es",
        "We ran gwo with agents = 7; all other parameters have their default values.",
        "Of each optimizer we have 20 independent trials on each problem, each with a budget of 100 evaluations.",
        "40 trials of cma-es met a stopping criterion", "1 trial failed or found no finite value",
        "with each other optimizer by A12", "each at 0.05; a winner is named where all tests reject",
        "by Holm's method (Holm, 1979) within the problem at 0.05.",
        "numpy 2.4.6 and scipy 1.17.1 (Harris et al., 2020; Virtanen et al., 2020) on A & B processor.",
    ):  # fmt: skip
        assert said in found.text
    assert len(found.text.split()) <= 250
    assert not re.search(r" [,.;:)]|[,;:]\.|\.\.|,,|\( ", found.text.replace(HOSTILE, "wolf"))


def test_nothing_is_said_of_what_was_not_done(make, tmp_path):
    one = methods(Findings(Results(make(tmp_path / "one", ("p",), ("a",), trials=2)))).text
    few = methods(Findings(Results(make(tmp_path / "few", trials=1)))).text
    for test in ("Friedman", "A12", "Holm", "failed", "constraints", "noise", "The trials used"):
        assert test not in one
    assert "With these trials nothing is tested." in few
    assert "Holm" not in few


def test_many_optimizers_and_problems_stay_within_the_words(make, tmp_path):
    labels = tuple(f"o{number}" for number in range(15))
    many = make(tmp_path / "many", tuple(f"p{number}" for number in range(9)), labels, trials=2, record=ENVIRONMENT,
                options={label: {"an_option": number} for number, label in enumerate(labels)})  # fmt: skip
    text = methods(Findings(Results(many))).text
    assert "o5 and 9 others." in text
    assert "The study's file has every parameter that has not its default value." in text
    assert len(text.split()) <= 250


def test_results_of_others_are_said_to_be_theirs():
    ours, theirs = Entry("gwo", "gwo"), Entry("imported:A", "A")
    made = "The results of A were made elsewhere and imported."
    assert parameters(study(theirs)) == made
    assert parameters(study(ours, theirs)) == f"{made} All other parameters have their default values."


def test_versions_of_several_machines():
    other = {"python": "3.12.1", "packages": {"numpy": None}, "processor": "C"}
    assert machine([ENVIRONMENT, other])[0].startswith("The trials used Python 3.11.7 and 3.12.1, backlash-bench 0.1.0")
    assert machine([]) == []


def test_every_citation_has_its_work_and_every_work_is_complete(found):
    keys = [work.key for work in parse(found.bibtex)]
    in_latex = {key for each in re.findall(r"\\cite\{([^}]*)\}", found.latex) for key in each.split(",")}
    assert keys == sorted(in_latex)
    assert set(re.findall(r"[\[ ]@([a-z0-9]+)(?=[\];])", found.markdown)) == set(keys)
    assert read(Path(module.__file__).with_name(module.BIBLIOGRAPHY)).keys() <= set(keys)


def test_unreadable_bibtex_is_told_and_costs_nothing_else():
    works, of, warnings = bibliography(study(Entry("x", "x"), Entry("y", "y")), {"x": Description("@misc{a, title={")})
    assert warnings[0].startswith("x is not cited: ")
    assert of == {"x": [], "y": []}
    assert "holm1979" in works


def test_works_under_one_key_are_told_apart():
    told = {"x": Description("@misc{a, year=1}"), "y": Description("@misc{A, year=3} @misc{a, year=1}")}
    works, of, _ = bibliography(study(Entry("x", "x"), Entry("y", "y")), told)
    assert of == {"x": ["a"], "y": ["A-2", "a"]}
    assert works["A-2"].author_year != works["a"].author_year


@settings(max_examples=30)
@given(st.text(min_size=1))
def test_a_text_is_never_read_as_a_citation_or_as_markup(text):
    written = module._written(["We ran ", text], prose, lambda _: "CITED")
    assert "CITED" not in written
    assert written.replace("\n", "").isascii()


def run(folder, *command):
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
    return done.stdout


@pytest.mark.skipif(not LATEX, reason="pdflatex or bibtex is missing")
def test_latex_and_bibtex_compile_without_a_warning(found, tmp_path):
    (tmp_path / "methods.tex").write_text(found.latex, encoding="utf-8")
    (tmp_path / "references.bib").write_text(found.bibtex, encoding="utf-8")
    body = "\\input{methods}\n\\bibliographystyle{plain}\n\\bibliography{references}"
    source = f"\\documentclass{{article}}\n\\begin{{document}}\n{body}\n\\end{{document}}\n"
    (tmp_path / "document.tex").write_text(source, encoding="utf-8")
    latex = ("pdflatex", "-halt-on-error", "-interaction=nonstopmode", "document.tex")
    run(tmp_path, *latex)
    assert "Warning" not in run(tmp_path, "bibtex", "document")
    run(tmp_path, *latex)
    log = run(tmp_path, *latex)
    assert "undefined" not in log
    assert "Missing character" not in log


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("bibtex") is None, reason="bibtex is not installed")
def test_a_doi_with_an_underscore_compiles_with_plainnat_and_as_elsarticle_sets_it(tmp_path):
    entry = "@article{a,\n  author = {A. B.},\n  title = {T},\n  year = 2000,\n  doi = {10.1/x_y_1}\n}\n"
    (tmp_path / "references.bib").write_text(f"{section.DOI}\n\n{entry}", encoding="utf-8")
    assert [work.key for work in parse((tmp_path / "references.bib").read_text(encoding="utf-8"))] == ["a"]
    body = r"\cite{a}\bibliographystyle{plainnat}\bibliography{references} \ifdefined\href \href{a}{\path{x_y}}\fi"
    source = rf"\documentclass{{article}}\usepackage{{natbib}}\begin{{document}}{body}\end{{document}}"
    (tmp_path / "d.tex").write_text(source, encoding="utf-8")
    for command in (["pdflatex", "-interaction=nonstopmode", "d.tex"], ["bibtex", "d"]):
        assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0
    done = subprocess.run(["pdflatex", "-halt-on-error", "d.tex"], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 0
    assert "x_y_1" in (tmp_path / "d.bbl").read_text(encoding="utf-8")
