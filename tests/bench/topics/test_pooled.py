"""Every sentence about values and trials holds where instances are pooled, alone and beside other problems."""

import pytest

from bench import Results, Study, run
from bench.topics.anytime import section as anytime
from bench.topics.comparison import section as comparison
from bench.topics.datasets import section as datasets
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.landscapes import section as landscape
from bench.topics.suite import section as suite
from bench.topics.time import environment
from bench.topics.trials import section as trials
from bench.topics.write import write_report

POOLED = {"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2], "instances": "1-3"}
OPTIMIZERS = [{"name": "gwo", "agents": 10}, {"name": "random-search"}]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return the folders of a study of pooled instances, and of one that has problems without instances, too."""

    def folder(name, trials, problems):
        study = {"name": name, "trials": trials, "budget": 100, "problems": problems, "optimizers": OPTIMIZERS}
        return run(Study.from_dict(study), tmp_path_factory.mktemp("run") / name, n_jobs=1).folder

    return {
        "pooled": folder("pooled", 3, [POOLED]),
        "mixed": folder("mixed", 5, [POOLED, {"name": "engineering-spring"}, {"name": "classical-sphere-d5-i1"}]),
    }


@pytest.fixture(scope="module")
def pooled(made):
    return Findings(Results(made["pooled"]))


@pytest.fixture(scope="module")
def mixed(made):
    return Findings(Results(made["mixed"]))


@pytest.mark.slow  # its words are tested in tests/bench/report/test_replication.py, too
def test_the_lead_counts_trials_by_problem(made, read):
    lead = "2 optimizers on 2 problems, 9 trials (3 on each of 3 instances) each, 100 evaluations a trial."
    assert lead in read(write_report(made["pooled"], n_jobs=1)).text


@pytest.mark.slow  # its words are tested in tests/bench/report/test_replication.py, too
def test_the_lead_counts_trials_where_some_problems_have_no_instances(made, read):
    both = "4 problems, 5 trials on each of 2 problems and 15 trials (5 on each of 3 instances) on each of 2 problems,"
    assert both in read(write_report(made["mixed"], n_jobs=1)).text
    assert (made["mixed"] / "tables" / "comparison-precisions.csv").exists()


def test_the_comparison_names_precisions(pooled):
    first, *others = comparison.section(pooled).items
    assert not others  # precisions are regrets already
    assert first.name == "comparison"
    assert first.caption.startswith("Median precision, the best objective value less the optimum of the instance,")
    assert "A cell holds the trials of all instances, 9 trials (3 on each of 3 instances)" in first.note


def test_precisions_and_objective_values_do_not_share_a_column(mixed):
    values, precisions, regret = comparison.section(mixed).items
    assert (values.name, precisions.name, regret.name) == ("comparison", "comparison-precisions", "regret")
    assert list(values.frame.index) == ["engineering-spring", "classical-sphere-d5-i1"]
    assert list(precisions.frame.index) == ["classical-sphere-d2", "classical-rastrigin-d2"]
    assert set(precisions.data["problem"]) == set(precisions.frame.index)
    assert values.caption.startswith("Median of the best objective value over the trials")
    assert precisions.caption.startswith("Median precision, the best objective value less the optimum of the instance,")
    assert "instance" not in values.note


def test_each_problem_says_what_its_values_are(mixed):
    sections = {each.title: each for each in datasets.section(mixed).sections}
    figure, cells = sections["classical-sphere-d2"].items[:2]
    assert cells.caption == "classical-sphere-d2: trials, failures, and the precision over trials."
    assert "precision" in figure.data
    assert "fun" not in figure.data
    assert sections["classical-sphere-d2"].text[0].startswith("A cell holds the trials of 3 instances, and")
    figure, cells = sections["engineering-spring"].items[:2]
    assert cells.caption == "engineering-spring: trials, failures, and the best objective value over trials."
    assert "fun" in figure.data
    assert "instance" not in " ".join(sections["engineering-spring"].text)


def test_the_suite_says_which_values_are_precisions(pooled, mixed):
    assert "Its instances (3 each) are pooled" in " ".join(suite.section(pooled).text)
    text = " ".join(suite.section(mixed).text)
    assert "On 2 of 4 problems, the instances (3 each) are pooled" in text
    assert "The values of the others are objective values." in text


@pytest.mark.slow
def test_regret_is_from_the_optimum_of_an_instance(pooled, mixed):
    def caption(findings):
        (each,) = anytime.section(findings).sections
        return next(item.caption for item in each.items if item.name == "regret-curves")

    assert "less the optimum of the instance, over" in caption(pooled)
    assert "reaches the optimum, to 1e-08." in caption(pooled)
    assert "less the optimum of the problem or instance, over" in caption(mixed)
    assert "to a relative 1e-10 or 1e-08 where instances are pooled." in caption(mixed)


def test_other_parts_say_how_instances_count(pooled):
    assert "In these checks every instance is a problem of its own." in integrity.section(pooled).text
    assert landscape.section(pooled).text[0].endswith("Of pooled instances, the first is described.")
    assert "Where instances are pooled, the trials of all of them count" in " ".join(trials.section(pooled).text)
    assert "the problem with its instance, the optimizer" in environment.section(pooled).text[0]


def test_a_study_without_instances_does_not_speak_of_them(make, tmp_path):
    findings = Findings(Results(make(tmp_path / "s")))
    parts = (comparison, integrity, trials, environment)
    text = [sentence for part in parts for sentence in part.section(findings).text]
    assert "instance" not in " ".join([*text, *(item.caption for item in comparison.section(findings).items)])
