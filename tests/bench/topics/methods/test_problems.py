"""The table of the problems has every bound, and families say where their optima are from."""

from bench.results.results import Bounds, ProblemFacts
from bench.topics.methods.problems import bounds

BOX = {"x1": Bounds(-5.0, 5.0), "x2": Bounds(-5.0, 5.0)}
FACTS = {
    "bbob-f01-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "bbob-f08-d2": ProblemFacts(0.0, box=BOX, features={"suite": "bbob"}, optimum_source="the suite"),
    "fit-1": ProblemFacts(2.5, box={"A": Bounds(0.0, 1.0), "t0": Bounds(0.0, 4.8)}),
    "gone": ProblemFacts(reason="it cannot be loaded"),
}


def test_the_file_has_every_bound_and_where_optima_are_from():
    rows = bounds(FACTS).set_index(["problem", "variable"])
    assert rows.at[("fit-1", "t0"), "upper"] == 4.8
    sources = rows["optimum_from"].fillna("").groupby("problem", sort=False).first()
    assert sources.tolist() == ["the suite", "the suite", "the problem itself", ""]
