"""The section on tuning; a is the default, b the tuned one, and optimizers find about 5, 6 and 7 on p to v."""

from dataclasses import replace
from itertools import count

import pytest

from bench import Results
from bench.study.budget import Budget
from bench.study.tuned import Tuned, Tuning
from bench.topics.findings import Findings
from bench.topics.tuning import section as tuning

SEVEN = ("p", "q", "r", "s", "t", "u", "v")
OWN = Tuned(
    name="any", default="a", tuned="b", failed=1, evaluations=4_000, seconds=12.5,
    parameters={"agents": {"low": 5, "high": 300, "log": True}, "kind": {"choices": ["x", "y"]}},
    values={"agents": ["null", 9, 7, 20], "kind": ["x", "y", "x", "y"]}, scores=[0.5, 0.4, 0.3, 0.45],
    problems=[6, 6, 2, 6], importance={"agents": 0.9, "kind": 0.1},
)  # fmt: skip
TUNED = Tuning(
    "aocc", 4, 2, Budget.read(100), 1, ["f-i1", "g-i1"], "", "optuna 5, TPESampler and WilcoxonPruner", (OWN,)
)
SEALED = TUNED.sealed()


@pytest.fixture
def section(make, tmp_path):
    """Return a function that returns the section of a study with this record."""

    numbers = count()

    def build(record=SEALED, **options):
        usual = {"problems": SEVEN, "optimizers": ("a", "b"), "trials": 12, "tuning": record}
        return tuning.section(Findings(Results(make(tmp_path / f"s{next(numbers)}", **usual | options))))

    return build


def test_a_study_that_was_not_tuned_has_no_section(section):
    assert section(None) is None
    assert section(replace(TUNED, optimizers=(replace(OWN, default="z"),))) is None


@pytest.mark.parametrize("record", [TUNED, replace(SEALED, train=["f-i1"]), replace(SEALED, seed=2)])
def test_an_edited_record_or_one_without_a_hash_is_reported_and_claims_nothing_of_the_problems(section, record):
    found = section(record)
    assert "was tuned on" not in found.text[0]
    assert found.warnings[0].startswith("The record of the tuning ")
    assert "so it does not show on which problems the optimizers were tuned" in found.warnings[0]


def test_a_tuning_that_made_it_worse_or_changed_nothing_is_said_to(section):
    assert "Over these problems, the defaults are lower (p" in section().text[2]
    best = replace(OWN, tuned="a")
    found = section(replace(TUNED, optimizers=(best,)), optimizers=("a",))
    assert found.text[2] == "any: no configuration scored better than the defaults, so nothing was gained."


def test_few_trials_and_problems_support_no_claim(section):
    few = section(trials=2, problems=("p",)).text[2]
    assert "2 trials are too few to show a difference on a problem" in few


def test_one_problem_says_nothing_of_others(section):
    assert "One problem says nothing of others." in section(problems=("p",)).text[2]


def test_failed_cells_leave_a_sentence(section):
    text = section(skip=[(problem, "b") for problem in SEVEN]).text[2]
    assert text == "any: no problem has trials of both the defaults and the tuned parameters."


def test_it_warns_of_untuned_optimizers_other_budgets_and_common_functions(section):
    record = replace(TUNED, budget=Budget.read(7), train=["any-i1"]).sealed()  # "any" is the name of all
    _, untuned, budget, common = section(record, optimizers=("a", "b", "c")).warnings
    assert untuned.startswith("c was not tuned.")
    assert "had 100 evaluations, the tuning 7 evaluations" in budget
    assert common.startswith("Training and test problems are different instances of 1 common function")
