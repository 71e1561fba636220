"""The methods section: sentences follow the facts, three ways say the same, and every citation has its work."""

import re
import shutil
import subprocess
from dataclasses import fields, replace

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
from bench.study.budget import Budget
from bench.study.descriptions import Description
from bench.study.rope import Rope
from bench.study.targets import KINDS, Targets
from bench.study.tuned import Tuned, Tuning
from bench.topics.findings.replication import Replication
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
from bench.topics.verdict.winner import winner_rule

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
    "tests": 0, "pairs": 0, "levels": Levels(0.05, 0.0), "blocks": 0, "permutation_tests": 0, "ranked_problems": 0,
    "known_optima": 0, "targets": 0, "target_set": KINDS["relative"], "aocc": 0, "early": {}, "checks": {},
    "rope": None, "landscapes": 0, "dominance": 0, "budgets": {}, "common": "", "confined": 0, "best2009": 0,
    "tuning": None, "suites": "", "sweeps": 0, "stopped": 0, "extensions": [], "needed": "", "stability": False,
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
        "dominance": 2, "landscapes": 3, "rope": Rope("1%"), "common": "at 400 evaluations", "confined": 2,
    } | changes  # fmt: skip


def methods(given):
    return write(given["study"], given["descriptions"], given)


TUNING = Tuning("aocc", 20, 3, Budget.read("100 * d"), 0, ["s", "t"], "", "optuna 5, TPESampler and WilcoxonPruner", (
    Tuned("gwo", "gwo", "gwo-tuned", {}, {}, [0.5], [2], 0, 9_000, 1.0, {"agents": 1.0}),
)).sealed()  # fmt: skip


def said(facts):
    return "\n".join(methods(facts).text)


def cited(found):
    return {key for keys in re.findall(r"\\cite\{([^}]*)\}", found.latex) for key in keys.split(",")}


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
        looked = replace(full()["study"], looks=(10, 20, 30))
        fields_own = full(study=looked, target_set=KINDS["precisions"], aocc=2, best2009=2)
        many = full(study=study([f"o{place}" for place in range(33)]), needed="formula", stability=True)
        swept = full(sweeps=1, tuning=TUNING)
        known = [cited(methods(facts)) for facts in (full(), fields_own, many, swept)]
        assert library().keys() <= set.union(*known)

    def test_the_looks_are_told(self):
        several = replace(full()["study"], looks=(10, 20, 30))
        text = said(full(study=several, stopped=1))
        assert "28 to 30 independent trials (at most 30, by declared looks)" in text
        assert "declared looks at 10, 20 and 30 trials, at each of which all pairs of a problem are tested" in text
        assert "1 cell was decided against every rival" in text
        assert "the function of Lan and DeMets (Lan and DeMets, 1983)" in text
        assert "group sequential procedure (Ye et al., 2013)" in text
        assert "no cell was decided" in said(full(study=several))
        assert "looks" not in said(full())

    def test_undeclared_extensions_and_estimates_are_told(self):
        text = said(full(extensions=[(10, 30)], needed="simulation", stability=True))
        assert "10 trials of each cell were complete when 30 were asked for, and no looks had been declared" in text
        assert "this is optional stopping" in text
        assert "by simulating the test on resamples of the trials" in text
        assert "by Noether’s formula (Noether, 1987)" in said(full(needed="formula"))
        assert "random subsets of them (Politis and Romano, 1994)" in text
        assert "optional stopping" not in said(full())

    def test_every_citation_has_its_work_and_every_work_is_cited(self):
        found = methods(full())
        keys = [work.key for work in parse(found.bibtex)]
        assert keys == sorted(cited(found))
        assert set(re.findall(r"@([a-z0-9]+)[];]", found.markdown)) == set(keys)
        names = [work.author_year for work in parse(found.bibtex)]
        assert all(re.search(rf"[(;] ?{re.escape(name)}[);]", "".join(found.text)) for name in names)
        assert found.bibtex == methods(full()).bibtex

    @pytest.mark.parametrize(
        ("chosen", "sentence"),
        [
            ("relative", "between the median first value of the trials and the known optimum on 1 problem and the"),
            ("precisions", "the 51 target precisions of COCO from 100 to 1e-8 (Hansen et al., 2021), differences from"),
            ([1.0, 0.1], "by 2 target precisions (1.0 and 0.1), differences from the known optimum on 1 problem"),
            (["5%", "1%"], "by values within 5% and 1% of the known optimum on 1 problem"),
            ("quantiles", "by quantiles of the best values of all trials on a problem"),
            ("tolerance", "by multiples of the tolerance of the expected metrics"),
        ],
    )
    def test_the_targets_are_stated(self, chosen, sentence):
        text = said(full(target_set=Targets.read(chosen), aocc=2))
        assert sentence in text
        assert (", with simulated restarts" in text) == (chosen != "relative")
        assert "The area over the convergence curve (van Stein et al., 2024) is given on 2 problems with a" in text

    def test_sweeps_and_tuning_are_told_where_there_are_any(self):
        text = said(full(sweeps=2, tuning=TUNING))
        assert "Of 2 sweeps over parameters we report main effects and interactions by functional ANOVA" in text
        assert "We tuned gwo at the same budget each, as guidelines ask (Bartz-Beielstein et al., 2020; LaTorre" in text
        assert (
            "20 configurations, the defaults first, 3 runs of 100 d evaluations on each of 2 training problems" in text
        )
        assert "training problems that are not among the test problems, with optuna 5" in text
        trained = replace(TUNING, train=[full()["study"].problems[0].name]).sealed()
        assert "not among the test problems" not in said(full(tuning=trained))
        assert "for the area over the convergence curve (van Stein et al., 2024); this took 9,000 evaluations." in text
        assert "for the mean logarithm of the median regret" in said(full(tuning=replace(TUNING, objective="regret")))
        assert "that of PED-ANOVA (Watanabe et al., 2023)." in text
        assert "tuned" not in said(full())

    def test_the_run_is_told(self):
        text = said(full())
        for words in (
            "We compared 3 optimizers on 3 problems (p, q and r): gwo (Mirjalili et al., 2014), alo (Mirjalili, 2015) ",
            "and cma-es (Hansen and Ostermeier, 2001; Hansen et al., 2019).",
            "We ran gwo with agents = 7, handling = box; all other parameters have their default values.",
            "We ran 28 to 30 independent trials (of 30 planned) of each optimizer on each problem, each with a budget",
            "on each problem, each with a budget of 10,000 evaluations of the objective function.",
            "2 problems have constraints (Coello Coello, 2002): only values at feasible points count, and infeasible",
            "as worse than all feasible ones, in the order of their total violation (Deb, 2000).",
            "2 trials failed or found no finite value;",
            "We tested the optimizers for a bias towards the centre of the search space, by errors with the optimum at",
            "at the centre and away from it (Kudela, 2022).",
            "We tested gwo and alo for structural bias, by tests of whether best points on pure noise are uniform in",
            "Python 3.11.7, backlash-bench 0.1.0, numpy 2.4.6 (", "commit 0123456789)",
            "on A & B processor.",
            "every pair of optimizers", "(in 1 of 9 pairs, where more than 10% of the values are tied",
            "Holm’s method (Holm, 1979) over all 9 tests of all problems controls the chance of any false claim",
            "Across problems (2 of 3,",
            "the known optimum on 1 problem and the lowest value that any trial found on the others",
        ):  # fmt: skip
            assert words in text
        assert "pandas" not in text
        assert len(methods(full()).text) == 3

    @pytest.mark.parametrize(
        ("changes", "gone"),
        [
            ({"failed": 0}, "failed"), ({"permutation_tests": 0}, "permutation"), ({"targets": 0}, "running time"),
            ({"checks": {"gwo": [STRUCTURE]}}, "Kudela"), ({"checks": {"gwo": [CENTRE]}}, "pure noise"),
            ({"early": {"gwo": 0}}, "stopping"), ({"environments": ()}, "used"), ({"descriptions": {}}, "Mirjalili"),
            ({"ranked_problems": 1}, "Friedman"), ({"ranked_problems": 3}, "of 3,"), ({"replications": ONE}, "planned"),
            ({"tests": 0}, "Schüürhuis"), ({"study": study()}, "handling"),
            ({"study": study(problems=["p"]), "ranked_problems": 1}, "of all problems"),
            ({"study": study(["gwo", "alo"])}, "Benavoli et al., 2016"),
            ({"study": study(["gwo", "alo"])}, "letter"), ({"known_optima": 3}, "lowest value that any"),
            ({"known_optima": 0}, "the known optimum on"), ({"known": {}}, "constraints"),
            ({"common": ""}, "budgets differ"), ({"confined": 0}, "repaired points"),
            ({"dominance": 0}, "U-scores"), ({"dominance": 3}, "U-scores on"),
        ],
    )  # fmt: skip
    def test_a_sentence_that_is_not_true_is_not_said(self, changes, gone):
        assert gone in said(full())
        changed = methods(full(**changes))
        assert gone not in "".join(changed.text)
        assert cited(changed) == {work.key for work in parse(changed.bibtex)}

    @pytest.mark.parametrize(
        ("handling", "words"),
        [
            ("death", "count, and the optimizers saw infeasible points with an infinite value."),
            ("penalty", "with a static penalty, 1,000,000 times their total violation."),
            ("repair", "every point was repaired by the rule of the problem before it was evaluated."),
        ],
    )
    def test_the_handling_of_constraints(self, handling, words):
        assert words in said(full(study=study(constraints=handling)))
        assert "Deb, 2000" not in said(full(study=study(constraints=handling)))
        assert "All problems have constraints" in said(
            full(study=study(constraints=handling), known=dict.fromkeys("pqr", KNOWN["p"]))
        )

    def test_pooled_instances_have_precisions_and_trials_by_instance(self):
        facts = ProblemFacts(0.0, box={"x1": (-5, 5), "x2": (-5, 5)}, optimum_source="the definition of the suite")
        known = dict.fromkeys("pqr", facts)
        text = said(full(known=known, replications=[Replication(3, 3, 9, 9, 3)]))
        assert "A problem is a function in one dimension whose 3 instances are pooled (Hansen et al., 2021)." in text
        assert "We ran 9 independent trials (3 on each of 3 instances) of each optimizer on each problem, each" in text
        assert (
            "The score of a trial is its precision, the lowest objective value that it found less the optimum of the"
            in text
        )
        assert "The optimum of the instances is from the definition of the suite." in text
        assert "the problem with its instance, the optimizer and the number of the trial." in text
        assert "planned" not in text

    def test_problems_with_and_without_instances_have_their_own_scores_and_trials(self):
        text = said(full(replications=[Replication(2, 3, 15, 15, 5), Replication(1, 1, 5, 5, 5)]))
        assert "Each of 2 problems is a function in one dimension whose 3 instances are pooled" in text
        assert (
            "Of each optimizer we ran 15 independent trials (5 on each of 3 instances) on each of 2 problems and "
            "5 independent trials on each of 1 problem, each with a budget of"
        ) in text
        assert "the lowest objective value that it found; where instances are pooled it is the precision" in text
        assert "of 15 planned" not in text

    def test_many_problems_of_suites_are_counted_by_suite(self):
        words = "7 functions of bbob in dimensions 2, 5 and 10"
        text = said(full(study=study(problems=[f"p{number}" for number in range(21)]), suites=words))
        assert f"on 21 problems ({words}): " in text
        assert "on 3 problems (p, q and r): " in said(full(suites="3 functions of bbob in dimension 2"))

    def test_objective_box_optimum_and_sweep_are_stated(self):
        box = {"A": (-1.0, 1.0), "t0": (0.0, 4.0)}
        fit = ProblemFacts(
            2.0, box=box, features={"sweep": "the gap"}, measure="the RMSE in rpm", optimum_source="a fit"
        )
        text = said(full(known=dict.fromkeys("pqr", fit)))
        for words in (
            "The objective, which is minimised, is the RMSE in rpm.",
            "The search space is the box with the bounds of each variable in tables/problems.csv; the dimension d",
            "The problems are steps of one sweep, the gap, and therefore no independent sample.",
            "The score of a trial is the lowest objective value that it found. The optimum is from a fit.",
        ):
            assert words in text
        assert "No optimum is known" in said(full())
        known = {"p": fit, "q": replace(fit, features={}, measure=""), "r": ProblemFacts(box={"x": (-5, 5)})}
        text = said(full(known=known))
        assert "is the RMSE in rpm on p." in text
        assert "tables/problems.csv on p and q and [-5, 5]^d on r; the dimension d is 1 or 2." in text
        assert "from a fit on p and q; of 1 problem it is not known, and the best value found" in text
        assert "are steps of one sweep, the gap" not in text

    def test_box_and_repair_are_explained_where_they_are_used(self):
        values = {"gwo": {"handling": "box"}, "alo": {"handling": "repair"}, "cma-es": {}}
        text = said(full(descriptions={name: Description("", own, {}) for name, own in values.items()}))
        assert "Points outside the box that gwo proposed were taken into the box (handling = box)" in text
        assert "Points that alo proposed were taken into the box and then, by the problem’s own rule" in text
        assert "(handling = repair)" not in said(full())

    def test_the_resamples_of_the_bootstrap_and_the_rule_for_a_winner_are_stated(self):
        text = said(full())
        assert "Mean ranks have 95% intervals from 999 bootstrap resamples of the trials of each cell" in text
        assert "stratified by problem and optimizer (Agarwal et al., 2021) of 9,999 resamples." in text
        assert winner_rule(looks=False) in text
        many = said(full(study=study([f"o{place}" for place in range(33)])))
        assert "from 199 bootstrap resamples" in many
        assert "(Agarwal et al., 2021) of 999 resamples." in many
        assert "Mean ranks have" not in said(full(replications=[Replication(3, 1, 1, 30, 30)]))

    def test_one_optimizer_one_problem_one_trial(self):
        facts = NOTHING | {
            "study": study([Entry("gwo", "wolf")], ["p"], trials=1), "replications": [Replication(1, 1, 1, 1, 1)]
        }  # fmt: skip
        (paragraph,) = methods(facts).text
        assert paragraph.startswith(
            "We ran wolf (the optimizer gwo) on 1 problem (p). All parameters have their default"
        )
        assert "We ran 1 independent trial, with a budget of 10,000 evaluations" in paragraph
        assert methods(facts).bibtex == ""

    def test_changed_code_and_several_machines_are_told(self):
        other = ENVIRONMENT | {"python": "3.12.1", "processor": "C", "git": {"commit": "f" * 40, "dirty": True}}
        text = said(full(environments=[ENVIRONMENT, other, {"python": None, "packages": {"numpy": None}, "git": None}]))
        assert "Python 3.11.7 and 3.12.1" in text
        assert "commit 0123456789 and ffffffffff, with local changes) on A & B processor and C." in text

    def test_the_commits_of_a_plugins_own_checkout_are_told(self):
        mine = {"mine": {"commit": "c" * 40, "dirty": True, "diff": "d" * 64}}
        text = said(full(environments=[ENVIRONMENT, ENVIRONMENT | {"git": None, "checkouts": mine}]))
        assert "(source code at commit 0123456789; mine at commit cccccccccc, with local changes) on A & B" in text

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

    def test_built_in_optimizers_cite_themselves(self):
        for name in ("alo", "cma-es", "da", "goa", "gwo"):
            optimizer = registry.load("optimizers", name)
            assert all("doi = {10." in work.fields for work in parse(optimizer.bibtex))
            assert optimizer() == optimizer()
            assert "bibtex" not in [field.name for field in fields(optimizer)]


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


def test_imported_trials_have_no_seed_of_ours_and_no_variance_is_left_undefined():
    imported = study((Entry("imported:A", "A"), Entry("imported:B", "B")))
    text = " ".join(write(imported, {}, NOTHING).text)
    assert "seed of the study" not in text
    mixed = " ".join(write(study((Entry("imported:A", "A"), "gwo")), {}, NOTHING).text)
    assert "Every trial that we ran draws its random numbers" in mixed
    assert "same variance" not in text
