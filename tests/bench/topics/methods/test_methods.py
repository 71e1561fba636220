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
from bench.topics.methods.methods import methods

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


def test_many_optimizers_and_problems_stay_within_the_words(make, tmp_path):
    labels = tuple(f"o{number}" for number in range(15))
    many = make(tmp_path / "many", tuple(f"p{number}" for number in range(9)), labels, trials=2, record=ENVIRONMENT,
                options={label: {"an_option": number} for number, label in enumerate(labels)})  # fmt: skip
    text = methods(Findings(Results(many))).text
    assert "o5 and 9 others." in text
    assert "The study's file has every parameter that has not its default value." in text
    assert len(text.split()) <= 250


def test_every_citation_has_its_work_and_every_work_is_complete(found):
    keys = [work.key for work in parse(found.bibtex)]
    in_latex = {key for each in re.findall(r"\\cite\{([^}]*)\}", found.latex) for key in each.split(",")}
    assert keys == sorted(in_latex)
    assert set(re.findall(r"[\[ ]@([a-z0-9]+)(?=[\];])", found.markdown)) == set(keys)
    suites = {"hansen2021"}  # whose running times are reported
    assert read(Path(module.__file__).with_name(module.BIBLIOGRAPHY)).keys() <= set(keys) | suites


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
