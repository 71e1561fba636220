"""Imported results beside results that were made here, through every reader of a folder."""

import json

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from bench import BenchError, Results, load_problem, load_results
from bench.analysis.cells import budgets as budgets_of
from bench.cli.app import app
from bench.execution.verify import verify
from bench.formats.importing import import_results
from bench.storage.folder import Folder
from bench.study import Entry, Study
from bench.study.targets import Targets
from bench.topics.answer import section as answer
from bench.topics.findings import Findings
from bench.topics.methods.methods import methods
from bench.topics.trust import section as trust
from bench.topics.trust.checks import checks
from bench.trial.columns import packed
from bench.trial.trial import Trial
from tests.bench.formats.made import make, record

ROWS = [
    "problem,optimizer,trial,evaluations,value",
    *(
        f"box-f01-d{d}-i{i},archived,{trial},{at},{value / i}"
        for d in (2, 3)
        for i in (1, 2, 3, 4)
        for trial in (0, 1)
        for at, value in ((1, 8.0), (30 + trial, 0.5), (400 * d + trial, 0.25))
    ),
    "",
]
MINE = {f"box-f01-d{d}-i{i}": d for d in (2, 5) for i in (1, 2, 7)}


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    place = tmp_path_factory.mktemp("archive")
    (place / "runs.csv").write_text("\n".join(ROWS))
    import_results(place / "runs.csv", place / "archive")
    return place / "archive"


@pytest.fixture(scope="module")
def mine(tmp_path_factory):
    """A study whose budget is 120, on instances and dimensions of which the archive has a part."""
    return make(tmp_path_factory.mktemp("own") / "mine", MINE, ("own",), trials=3).paths[0]


class TestUnited:
    @pytest.mark.slow
    def test_the_problems_that_both_have_are_compared(self, mine, archive):
        both = Results(mine, archive)
        assert [entry.label for entry in both.study.problems] == ["box-f01-d2-i1", "box-f01-d2-i2"]
        assert both.frame.groupby("optimizer").size().to_dict() == {"own": 6, "archived": 4}
        assert {problem for problem, _, _ in both.traces} == {"box-f01-d2-i1", "box-f01-d2-i2"}

    def test_the_differences_are_said(self, mine, archive):
        shared, mine_more, archive_more, trials, budgets = Results(mine, archive).differences
        assert shared == "The folders share 2 problems; only those are compared."
        assert mine_more.startswith("Left out of mine: 4 problems that not all folders have, as box-f")
        assert archive_more.startswith("Left out of archive: 6 problems that not all folders have, as box-f")
        assert trials == "Trials of an optimizer on a problem differ: at most 3 in mine and 2 in archive."
        assert budgets.startswith(
            "Budgets differ: 120 evaluations in mine and at most 801 evaluations at d = 2 in archive."
        )
        assert Results(mine).differences == Results(archive).differences == []

    def test_each_optimizer_keeps_its_own_budget(self, mine, archive):
        both = Findings(Results(mine, archive))
        assert both.trials.budgets == {"box-f01-d2-i1": 801, "box-f01-d2-i2": 801}
        assert {cell: most for cell, most in both.trials.allowed.items() if cell[0].endswith("i1")} == {
            ("box-f01-d2-i1", "own"): 120,
            ("box-f01-d2-i1", "archived"): 801,
        }
        verdicts = both.of(checks).set_index("check")["verdict"]
        assert verdicts["records"] == "pass"
        frame = pd.DataFrame({"problem": ["box-f01-d2-i1"] * 2, "optimizer": ["own", "archived"]})
        assert budgets_of(frame, both.trials.allowed).tolist() == [120.0, 801.0]

    @pytest.mark.slow
    def test_values_are_compared_at_the_largest_budget_that_all_had(self, mine, archive):
        both = Findings(Results(mine, archive))
        assert both.trials.common == {"box-f01-d2-i1": 120, "box-f01-d2-i2": 120}
        assert both.trials.common_words == "at 120 evaluations, the largest budget that all had"
        whole, compared = both.trials.whole, both.trials.frame
        for place, row in whole.iterrows():
            value = both.trials.traces[row["problem"], row["optimizer"], row["trial"]].at(120)
            assert compared.loc[place, "fun"] == value
        assert (compared["fun"] > whole["fun"]).any()
        assert compared.drop(columns="fun").equals(whole.drop(columns="fun"))
        assert both.trials.comparable.unknown == {}
        assert both.anytime.hits(both.trials.optimizers)["spent"].max() > 120  # targets count all evaluations
        assert Findings(Results(mine)).trials.common_words == ""

    def test_each_optimizer_has_its_own_plan(self, mine, archive):
        """Two trials of an archived optimizer are not too few beside three of ours."""
        both = Results(mine, archive)
        assert both.planned == {"own": 3, "archived": 0}
        found = Findings(both, Targets.read("precisions"))
        assert found.of(checks).set_index("check").loc["completeness", "verdict"] == "pass"
        assert not found.trials.coverage["missing"].any()

    def test_the_methods_give_each_budget_and_say_what_was_imported(self, mine, archive):
        text = methods(Findings(Results(mine, archive))).text
        assert "each with a budget of 120 evaluations for own and 801 evaluations at d = 2" in text
        assert "The results of archived were made elsewhere and imported." in text
        assert "All other parameters have their default values." in text
        assert "planned" not in text

    def test_folders_without_a_problem_in_common_are_refused(self, tmp_path, archive):
        other = make(tmp_path / "other", {"sphere-2": 2}).paths[0]
        with pytest.raises(BenchError, match="other and archive have no problem in common, such as 'sphere-2' and"):
            Results(other, archive)

    def test_seeds_keep_their_digits_beside_trials_without_one(self, tmp_path, archive):
        large, folder = 2**62 + 1, Folder(tmp_path / "one")
        folder.path.mkdir()
        problem, optimizer = (Entry(label, label) for label in ("box-f01-d2-i1", "any"))
        folder.claim(Study("one", (problem,), (optimizer,), trials=1, budget=120))
        with folder.store.writer() as writer:
            writer.add(Trial("box-f01-d2-i1", "any", 0, large), packed(record([3.0, 1.0], 2)))
        seeds = load_results(folder.path, archive)["seed"]
        assert seeds.dtype == "Int64"
        assert seeds.dropna().tolist() == [large]


def final_values(tmp_path, budgets, ends=1.0, problem="p"):
    """Import a table of final values alone, of optimizers with these budgets; the first ends lowest."""
    lines = [
        f"{problem}{number},{label},{trial},{max(round(spent * (ends if trial else 1.0)), 1)},{place + trial / 100}"
        for number in (1, 2)
        for place, (label, spent) in enumerate(budgets.items())
        for trial in range(8)
    ]
    (tmp_path / "t.csv").write_text("\n".join(["problem,optimizer,trial,evaluations,value", *lines, ""]))
    import_results(tmp_path / "t.csv", tmp_path / "t")
    return tmp_path / "t"


class TestFinalValues:
    def test_the_budget_of_each_optimizer_is_the_most_that_it_spent(self, tmp_path):
        spent = {"a": 10_000, "b": 1_000, "c": 10_050}
        found = Results(final_values(tmp_path, spent, ends=0.1))
        assert found.study.budget == 10_050
        assert found.budgets == spent

    def test_by_dimension_where_the_study_s_is(self, tmp_path):
        rows = ["problem,optimizer,trial,evaluations,value", "f-d2-i1,a,0,20,1", "f-d3-i1,a,0,30,1", "f-d3-i1,b,0,9,1"]
        (tmp_path / "t.csv").write_text("\n".join([*rows, ""]))
        import_results(tmp_path / "t.csv", tmp_path / "t")
        assert Results(tmp_path / "t").budgets == {"a": {"2": 20, "3": 30}, "b": {"2": 20, "3": 9}}

    def test_an_optimizer_that_declared_its_end_may_have_had_the_whole_budget(self, tmp_path):
        folder = final_values(tmp_path, {"a": 10_000, "b": 1_000})
        with Folder(folder).store.writer() as writer, writer.transaction():
            row = {"status": "ok", "fun": 0.5, "nfev": 900, "x": {}, "metrics": {}, "stop": "tolfun"}
            writer.put(packed(row) | {"problem": "p1", "optimizer": "b", "trial": 8, "environment": 1})
        assert Results(folder).budgets == {"a": 10_000, "b": 10_000}

    def test_at_unequal_budgets_nothing_is_compared_that_is_not_known(self, tmp_path):
        """Trials end at success, so those of b that ended early are the lucky ones."""
        found = Findings(Results(final_values(tmp_path, {"a": 10_000, "b": 1_000}, ends=0.05)))
        assert found.trials.common == {"p1": 1_000, "p2": 1_000}
        assert answer.section(found).text == (
            "There is nothing to compare: no problem has trials of every optimizer that can be compared.",
        )
        assert trust.section(found).lines[0].text == (
            "a spent more evaluations than others had on p1 and p2, and what was found by then is not known, so it is "
            "not compared there."
        )

    def test_nothing_is_said_of_smaller_budgets_at_which_no_value_is_known(self, tmp_path):
        found = Findings(Results(final_values(tmp_path, {"a": 1_000, "b": 995})))
        assert found.trials.common == {}
        made = answer.section(found)
        assert made.cards[0].text == "a ends lowest on these 2 problems."
        assert "smaller budgets" not in f"{made.lines}"


def of_years(tmp_path, name, instances):
    """Import made-up runs on two functions of bbob, of which each has another instance twice."""
    rows = [
        f"{label},{name},{trial},{at},{load_problem(label).optimum + value / i}"
        for function in (1, 8)
        for i in instances
        for label in [f"bbob-f0{function}-d2-i{i}"]
        for trial in (0, 1)
        for at, value in ((1, 800.0), (30 + trial, 0.5), (200 + 7 * i, 0.25))
    ]
    (tmp_path / f"{name}.csv").write_text("\n".join([ROWS[0], *rows, ""]))
    import_results(tmp_path / f"{name}.csv", tmp_path / name)
    return tmp_path / name


def test_sets_of_different_years_keep_all_their_runs_of_a_function(tmp_path):
    """Instances of bbob are repetitions: an archive's running times do not depend on what stands beside it."""
    pytest.importorskip("cocoex", reason="the optimal values of bbob come from coco-experiment")

    def high(_, values):
        return record(values + 1000, 2)

    sets = [of_years(tmp_path, *each) for each in (("old", (1, 2, 3)), ("new", (3, 61, 62)), ("part", (2,)))]
    own = make(tmp_path / "own", {"bbob-f01-d2-i1": 2, "bbob-f01-d2-i9": 2}, ("mine",), 3, high).paths[0]
    both = Results(own, *sets)
    found = Findings(both, Targets.read("precisions"))
    assert found.trials.problems == ["bbob-f01-d2"]
    assert found.trials.whole.groupby("optimizer", observed=True).size().to_dict() == {
        "mine": 6, "old": 6, "new": 6, "part": 2
    }  # fmt: skip
    assert not found.trials.coverage["missing"].any()
    assert found.of(checks).set_index("check").loc["completeness", "verdict"] == "pass"
    for folder in sets[:2]:
        alone = Findings(Results(folder), Targets.read("precisions")).anytime.running_times.set_index(
            ["problem", "precision"]
        )
        beside = found.anytime.running_times.set_index(["optimizer", "problem", "precision"]).loc[folder.name]
        assert beside["ert"].tolist() == alone["ert"].loc[["bbob-f01-d2"]].tolist()
        assert np.isfinite(alone["ert"].astype(float)).any()
    shared, pooled, *left = both.differences
    assert shared == "The folders share 1 problem; only those are compared."
    assert pooled.endswith(
        "2 instances of own, 3 instances of old, 3 instances of new and 1 instance of part. No test pairs single "
        "runs; those over all problems pair functions."
    )
    assert left[0] == "Left out of old: 3 problems that not all folders have, as bbob-f08-d2-i1."
    assert "as cocopp does" in found.results.differences[1]


def test_every_command_that_reads_a_folder_reads_an_imported_one(archive, tmp_path):
    def call(*words):
        found = CliRunner().invoke(app, [str(word) for word in words])
        assert found.exit_code == 0, found.output
        return found.output

    assert "16 trials from runs.csv (csv, licence unknown)" in " ".join(call("status", archive).split())
    for kind in ("ioh", "coco", "csv"):
        call("export", archive, "--format", kind, "--output", tmp_path / kind)
    head = json.loads((tmp_path / "ioh/archived/IOHprofiler_f1_box-f01-d2-i1.json").read_text())
    assert head["scenarios"][0]["dimension"] == 2
    assert head["scenarios"][0]["runs"][0]["seed"] is None
    with pytest.raises(BenchError, match="holds imported trials, such as those of archived"):
        verify(archive)
    call("merge", archive, "-o", tmp_path / "merged")
    assert Results(tmp_path / "merged").frame.equals(Results(archive).frame)
