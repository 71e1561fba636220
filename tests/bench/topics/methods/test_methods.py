"""The methods section: sentences follow the facts, three ways say the same, and every citation has its work."""

import re
import shutil
import subprocess
from dataclasses import replace
from difflib import unified_diff

import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bench.analysis import Levels
from bench.analysis.comparable import Comparable
from bench.helpers.bibtex import parse
from bench.plugins import registry
from bench.results.results import ProblemFacts
from bench.study import Entry, Study
from bench.study.descriptions import Description
from bench.study.targets import KINDS, Targets
from bench.topics.findings.replication import Replication
from bench.topics.methods import section
from bench.topics.methods.methods import (
    LATEX,
    MARKDOWN,
    TEXT,
    cited_keys,
    library,
    merge_works,
    paragraphs,
    templates,
    write,
)

ENVIRONMENT = {
    "python": "3.11.7", "packages": {"backlash-bench": "0.1.0", "numpy": "2.4.6", "scipy": "1.17.1", "pandas": "3.1"},
    "processor": "A & B processor", "git": {"commit": "0123456789abcdef", "dirty": False},
}  # fmt: skip


def study(optimizers=("gwo", "alo", "cma-es"), problems=("p", "q", "r"), **options):
    entries = [
        [each if isinstance(each, Entry) else Entry(each, each) for each in some] for some in (problems, optimizers)
    ]
    return Study("s", *map(tuple, entries), **options)


KNOWN = {label: ProblemFacts(constraints="lexicographic") for label in ("p", "q")} | {"r": ProblemFacts()}
CENTRE, STRUCTURE = ({"check": name, "passed": False} for name in ("centre bias", "structural bias"))
ONE = [Replication(3, 1, 30, 30, 30)]


def described(*names):
    return {name: Description(registry.load("optimizers", name).bibtex) for name in names}


NOTHING = {
    "study": study(), "descriptions": {}, "selection": "", "replications": ONE, "known": {}, "empty": 0, "failed": 0,
    "not_compared": Comparable(pd.DataFrame(), pd.DataFrame(), {}, {}, {}, {}), "environments": [],
    "tests": 0, "pairs": 0, "levels": Levels(0.05, 0.0), "permutation_tests": 0, "ranked_problems": 0,
    "known_optima": 0, "targets": 0, "target_set": KINDS["relative"], "aocc": 0, "early": {}, "checks": {},
    "dominance": 0, "budgets": {}, "common": "", "confined": 0, "best2009": 0,
    "suites": "", "extensions": [], "needed": "", "stability": False,
    "subject": "", "subject_tested": "", "within": 0, "level_on_problems": 0.01,
}  # fmt: skip


def full(**changes):
    """Return facts of which every sentence can be said."""
    return NOTHING | {
        "study": study(optimizers=[Entry("gwo", "gwo", {"agents": 7, "handling": "box"}), "alo", "cma-es"]),
        "replications": [Replication(3, 1, 28, 30, 30)], "known": KNOWN, "failed": 2,
        "descriptions": described("gwo", "alo", "cma-es"), "environments": [ENVIRONMENT], "tests": 9, "pairs": 9,
        "levels": Levels(0.01, 0.035, 0.005), "permutation_tests": 1, "ranked_problems": 2, "known_optima": 1,
        "targets": 3, "early": {"cma-es": 3, "gwo": 0},
        "checks": {"gwo": [CENTRE, STRUCTURE], "alo": [CENTRE, STRUCTURE], "cma-es": [CENTRE]},
        "dominance": 2, "common": "at 400 evaluations", "confined": 2,
    } | changes  # fmt: skip


def methods(given):
    return write(given["study"], given["descriptions"], given)


def said(facts):
    return "\n".join(methods(facts).text)


def cited(found):
    return {key for keys in re.findall(r"\\cite\{([^}]*)\}", found.latex) for key in keys.split(",")}


FIT = ProblemFacts(
    2.0, box={"A": (-1.0, 1.0), "t0": (0.0, 4.0)}, measure="the RMSE in rpm",
    optimum_source="a fit",
)  # fmt: skip
FUNCTION = ProblemFacts(0.0, box={"x1": (-5, 5), "x2": (-5, 5)}, optimum_source="the definition of the suite")
MANY = {"study": study([f"o{place}" for place in range(33)])}
OTHER = ENVIRONMENT | {"python": "3.12.1", "processor": "C", "git": {"commit": "f" * 40, "dirty": True}}
UNKNOWN = {"python": None, "packages": {"numpy": None}, "git": None}
MINE = ENVIRONMENT | {
    "git": None, "checkouts": {"mine": {"commit": "c" * 40, "dirty": True, "diff": "d" * 64}}
}  # fmt: skip
ACCEPTED = {"gwo": {"handling": "box"}, "alo": {"handling": "repair"}, "cma-es": {}}

CASES = {
    "extended": {"extensions": [(10, 30)], "needed": "simulation", "stability": True},
    "needed by a formula": {"needed": "formula"},
    **{
        f"targets {chosen}": {"target_set": Targets.read(chosen), "aocc": 2}
        for chosen in ("relative", "precisions", [1.0, 0.1], ["5%", "1%"], "quantiles", "tolerance")
    },
    "no trial failed": {"failed": 0}, "no permutation test": {"permutation_tests": 0}, "no target": {"targets": 0},
    "no check for centre bias": {"checks": {"gwo": [STRUCTURE]}},
    "no check for structural bias": {"checks": {"gwo": [CENTRE]}},
    "nobody stopped": {"early": {"gwo": 0}}, "no environment": {"environments": ()},
    "not described": {"descriptions": {}},
    "one problem ranked": {"ranked_problems": 1}, "all problems ranked": {"ranked_problems": 3},
    "all trials there": {"replications": ONE}, "no test": {"tests": 0}, "usual options": {"study": study()},
    "one problem": {"study": study(problems=["p"]), "ranked_problems": 1},
    "two optimizers": {"study": study(["gwo", "alo"])},
    "all optima known": {"known_optima": 3}, "no optimum known": {"known_optima": 0}, "nothing known": {"known": {}},
    "equal budgets": {"common": ""}, "no repaired optimum": {"confined": 0}, "no U-scores": {"dominance": 0},
    "U-scores of all problems": {"dominance": 3},
    **{each: {"study": study(constraints=each)} for each in ("death", "penalty", "repair")},
    "constraints everywhere": {"study": study(constraints="death"), "known": dict.fromkeys("pqr", KNOWN["p"])},
    "instances": {"known": dict.fromkeys("pqr", FUNCTION), "replications": [Replication(3, 3, 9, 9, 3)]},
    "instances compared within": {"replications": [Replication(3, 3, 9, 9, 3)], "within": 3},
    "a subject": {"subject": "The first run named gwo.", "subject_tested": "gwo"},
    "some instances": {"within": 2, "replications": [Replication(2, 3, 15, 15, 5), Replication(1, 1, 5, 5, 5)]},
    "many problems of a suite": {
        "study": study(problems=[f"p{number}" for number in range(21)]),
        "suites": "7 functions of bbob in dimensions 2, 5 and 10",
    },
    "few problems of a suite": {"suites": "3 functions of bbob in dimension 2"},
    "fits": {"known": dict.fromkeys("pqr", FIT)},
    "problems of several kinds": {
        "known": {"p": FIT, "q": replace(FIT, features={}, measure=""), "r": ProblemFacts(box={"x": (-5, 5)})}
    },
    "box and repair": {"descriptions": {name: Description("", own, {}) for name, own in ACCEPTED.items()}},
    "many optimizers": MANY, "one trial": {"replications": [Replication(3, 1, 1, 30, 30)]},
    "several machines": {"environments": [ENVIRONMENT, OTHER, UNKNOWN]},
    "a plug-in's own checkout": {"environments": [ENVIRONMENT, MINE]},
    "one of everything": NOTHING | {
        "study": study([Entry("gwo", "wolf")], ["p"], trials=1), "replications": [Replication(1, 1, 1, 1, 1)]
    },
    "imported": NOTHING | {"study": study((Entry("imported:A", "A"), Entry("imported:B", "B")))},
    "imported beside others": NOTHING | {"study": study((Entry("imported:A", "A"), "gwo"))},
}  # fmt: skip


BEGINNING = 70  # letters of a sentence that a case does not have


def sentences(facts):
    return re.split(r"(?<=[a-z)]\.) (?=[A-Z])", said(facts).replace("\n", " "))


def test_the_sentences_of_every_case_are_the_committed_ones(committed):
    usual = sentences(full())
    lines = ["## everything", *usual]
    for name, changes in CASES.items():
        changed = [*unified_diff(usual, sentences(full(**changes)), lineterm="", n=0)][2:]
        changed = [line for line in changed if not line.startswith("@@")]
        lines += ["", f"## {name}", *(f"{line[:BEGINNING]} …" if line[0] == "-" else line for line in changed)]
    committed("methods-cases", "\n".join([*lines, ""]))


@pytest.mark.parametrize("changes", CASES.values(), ids=CASES)
def test_no_sentence_has_a_stray_space_or_comma(changes):
    assert not re.search(r" [,.;:)]|[,;:]\.|\.\.|,,|\( ", said(full(**changes)))


class TestMethods:
    def test_every_work_of_the_library_is_complete_and_cited_by_some_report(self):
        for key, work in library().items():
            assert re.fullmatch(r"[a-z]+\d{4}", key)
            assert work.author_year.endswith(key[-4:])
            assert re.search(r"\btitle = ", work.fields)
            place = {"article": "journal", "inproceedings": "booktitle", "misc": "howpublished", "phdthesis": "school"}
            place |= {"incollection": "booktitle", "book": "publisher"}
            assert f"  {place[work.kind]} = " in work.bibtex
            assert work.kind != "article" or "pages = " in work.fields
        fields_own = full(extensions=[(10, 30)], target_set=KINDS["precisions"], aocc=2, best2009=2)
        many = full(**MANY, needed="formula", stability=True)
        known = [cited(methods(facts)) for facts in (full(), fields_own, many)]
        assert library().keys() <= set.union(*known)

    @pytest.mark.parametrize("changes", CASES.values(), ids=CASES)
    def test_every_citation_has_its_work_and_every_work_is_cited(self, changes):
        found = methods(full(**changes))
        keys = [work.key for work in parse(found.bibtex)]
        assert keys == sorted(cited(found))
        assert set(re.findall(r"@([a-z0-9]+)[];]", found.markdown)) == set(keys)
        names = [work.author_year for work in parse(found.bibtex)]
        assert all(re.search(rf"[(;] ?{re.escape(name)}[);]", "".join(found.text)) for name in names)

    def test_unreadable_bibtex_is_told_and_costs_nothing_else(self):
        found = methods(full(descriptions=described("gwo") | {"alo": Description("@misc{a, title={")}))
        assert len(found.warnings) == 1
        assert found.warnings[0].startswith("alo is not cited: ")
        assert "gwo (Mirjalili et al., 2014), alo and cma-es." in found.text[0]

    @settings(max_examples=30)
    @given(st.text())
    def test_any_label_leaves_the_rest_as_it_is(self, label):
        entries = study([Entry("x", label, {"o": label}), "b"], [label])
        known = {label: ProblemFacts(measure=label, optimum_source=label, optimum=0.0, box={label: (0, 1)})}
        hostile = full(study=entries, known=known, descriptions={}, tests=1)
        found = methods(hostile)
        assert cited(found) == {work.key for work in parse(found.bibtex)}
        assert found.latex.replace("\n", "").isascii()
        assert found.latex.count("\n\n") == len(found.text)
        assert found.markdown.count("\n---\n") == 1


def test_works_under_one_key_are_told_apart():
    ours = parse("@misc{a, year=1} @misc{b, year=2}")
    works, named = merge_works(ours, parse("@misc{a, year=1} @misc{A, year=3} @misc{c, year=4}"))
    assert [work.key for work in named] == ["a", "A-2", "c"]
    assert [work.key for work in works] == ["a", "b", "A-2", "c"]


def filled(template, **values):
    return paragraphs(templates().from_string(template).render(values))


def test_three_ways():
    works = {work.key: work for work in parse("@misc{a, author={A}, year=1} @misc{b, author={B}, year=2}")}
    (prose,) = filled(
        "Of {{ x }} we say\n[@a; @b].\n{% if x %}\nSo p [@{{ key }}], q and r.\n{% endif %}", x="x_1", key="a"
    )
    assert cited_keys([prose]) == ["a", "b"]
    assert TEXT.write(prose, works) == "Of x_1 we say (A, 1; B, 2). So p (A, 1), q and r."
    assert MARKDOWN.write(prose, works) == r"Of x\_1 we say [@a; @b]. So p [@a], q and r."
    assert LATEX.write(prose, works) == r"Of x\_1 we say~\cite{a,b}. So p~\cite{a}, q and r."


def test_blank_lines_separate_paragraphs_and_none_is_empty():
    assert filled("a\nb\n\n{% if no %}\nc\n{% endif %}\n\n{{ x }} d", no=0, x="x\n\ny") == ["a b", "x y d"]


@given(st.text())
@example(" [@a] {{ y }}")
@example("[[ [@a]")
def test_data_is_never_read_as_a_template(label):
    (prose,) = filled("a {{ x }}.", x=label)
    assert cited_keys([prose]) == []
    assert TEXT.write(prose, {}) == " ".join(f"a {label}.".split())


def run(folder, *command):
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
    return done.stdout


@pytest.mark.skipif(not (shutil.which("pdflatex") and shutil.which("bibtex")), reason="pdflatex or bibtex is missing")
def test_latex_and_bibtex_compile_without_a_warning(tmp_path):
    names = [Entry("gwo", "50% of_$wölves$ & 日本 #1 {~^\\}", {"agents": "[x]"}), "alo", "cma-es", "da", "goa"]
    found = methods(full(study=study(names), descriptions=described("alo", "cma-es", "da", "goa")))
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
