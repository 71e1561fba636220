"""The table of the problems has every bound, and families say where their optima are from."""

from bench import load_problem
from bench.results.results import ProblemFacts
from bench.topics.methods.problems import problems_table

BOX = {"x1": (-5.0, 5.0), "x2": (-5.0, 5.0)}
FACTS = {
    "bbob-f01-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "bbob-f08-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "fit-1": ProblemFacts(2.5, box={"A": (0.0, 1.0), "t0": (0.0, 4.8)}),
    "gone": ProblemFacts(reason="it cannot be loaded"),
}


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
