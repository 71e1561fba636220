"""Problems in words: named by family where all of it is meant, and a table with every bound."""

import pytest

from bench import load_problem
from bench.results.results import ProblemFacts
from bench.topics.methods.problem_words import boxes, optima, problems_named, problems_table, suites

BOX = {"x1": (-5.0, 5.0), "x2": (-5.0, 5.0)}
FACTS = {
    "bbob-f01-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "bbob-f08-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "fit-1": ProblemFacts(2.5, box={"A": (0.0, 1.0), "t0": (0.0, 4.8)}),
    "gone": ProblemFacts(reason="it cannot be loaded"),
}


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        (["bbob-f01-d2", "bbob-f08-d2"], "the bbob problems"),
        (["bbob-f01-d2", "fit-1"], "bbob-f01-d2 and fit-1"),
        (list(FACTS), "all problems"),
    ],
)
def test_problems_are_named_by_family_only_where_all_of_it_is_meant(labels, words):
    assert problems_named(labels, FACTS) == words
    assert problems_named(["p"], {"p": ProblemFacts()}) == "the problem"


def test_boxes_and_optima_are_grouped():
    assert boxes(FACTS) == {"[-5, 5]^d": "the bbob problems", "": "fit-1"}
    assert optima(FACTS) == {"the suite": "the bbob problems", "the problem itself": "fit-1"}


def test_functions_of_whole_suites_are_counted_by_suite():
    def facts(suite, functions, sizes):
        return {
            f"{suite}-{each}-d{size}": ProblemFacts(
                box={f"x{i}": (0.0, 1.0) for i in range(size)}, features={"suite": suite, "function": each}
            )
            for each in functions
            for size in sizes
        }

    grid = facts("bbob", ("f01", "f02"), (2, 5))
    assert suites(grid) == "2 functions of bbob in dimensions 2 and 5"
    both = grid | facts("cec2022", ("f01",), (10,))
    assert suites(both) == "2 functions of bbob in dimensions 2 and 5 and 1 function of cec2022 in dimension 10"
    assert suites(grid | facts("bbob", ("f03",), (2,))) == ""
    assert suites(grid | {"i2": grid["bbob-f01-d2"]}) == ""
    assert suites(FACTS) == ""


def test_the_table_has_every_bound():
    table = problems_table(FACTS, {label: [label] for label in FACTS} | {"bbob-f01-d2": ["i1", "i2", "i3"]})
    assert list(table.frame["instances"]) == [3, 1, 1, 1]
    assert list(table.frame["box"]) == ["[-5, 5]^d", "[-5, 5]^d", "by variable", "–"]
    assert table.data.set_index(["problem", "variable"]).at[("fit-1", "t0"), "upper"] == 4.8
    assert "instances" not in problems_table(FACTS, {label: [label] for label in FACTS}).frame


def test_families_say_where_their_optima_are_from():
    assert load_problem("bbob-f01-d2-i1").optimum_source == "the definition of the suite"
    assert load_problem("engineering-spring").optimum_source == "the best known design"
    signature = load_problem("signature-03", unit="rpm")
    assert signature.optimum_source == "a reference fit, found by an exhaustive search"
    assert signature.measure == "the RMSE of the fitted signature in rpm"
