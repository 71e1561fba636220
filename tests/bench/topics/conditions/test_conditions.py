"""What differs between optimizers besides their algorithms: read from plug-ins and study, for any of them."""

import pytest

from bench import Study
from bench.study.descriptions import noted
from bench.topics.conditions import conditions


def study(*optimizers):
    return Study.from_dict({"name": "s", "problems": [{"name": "signature-03"}], "optimizers": list(optimizers)})


GWO, CMAES = {"name": "gwo"}, {"name": "cma-es"}

CASES = {
    "the thesis": Study.load("thesis"),
    "all options alike": study(GWO, {"name": "da"}),
    "another handling": study(GWO, CMAES | {"handling": "box"}),
    "imported": study({"name": "imported:A"}, {"name": "imported:B"}),
    "many ways": study(*(GWO | {"label": f"g{agents}", "agents": agents} for agents in range(3, 12))),
}


@pytest.mark.parametrize(
    ("case", "said"),
    [
        ("the thesis", "handling and start are box, midpoint for cma-es and repair, random for the 4 others"),
        ("all options alike", ""),
        ("another handling", "handling is repair for gwo and box for cma-es"),
        ("imported", ""),
        ("many ways", "agents is set in 9 ways"),
    ],
)
def test_what_differs_is_one_clause(case, said):
    own = CASES[case]
    assert conditions.differing(own, noted(own, {}), own.optimizers[0].label) == said


@pytest.mark.parametrize(("leader", "found"), [("gwo[agents=9]", False), ("da", True)])
def test_what_a_sweep_varies_is_its_question_and_no_condition_of_its_best(leader, found):
    own = study(GWO | {"options": {"agents": [5, 9]}}, {"name": "da", "agents": 9})
    text = conditions.differing(own, noted(own, {}), leader)
    assert text == ("agents is 5 for gwo[agents=5] and 9 for the 2 others" if found else "")
