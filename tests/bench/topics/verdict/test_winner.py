"""The verdict: every case of headline, lines and details as committed texts, and its facts by name."""

from dataclasses import replace
from itertools import permutations, product

import pandas as pd
import pytest

from bench.analysis import Levels
from bench.report.wording import percent
from bench.topics.conditions.differing import Differing
from bench.topics.verdict.clock import Clock
from bench.topics.verdict.winner import Across, Stage, Standing, verdict

NAN = float("nan")
BOTH, ACROSS, NONE = Levels(0.01, 0.035, 0.005), Levels(0.0, 0.045), Levels(0.0, 0.0)


def standing(ranks, *, beaten=(), lower=(), problems=18, first=15, separable=14, worse=0, **more):
    """Return the standing of optimizers by mean rank; the first has the numbers given, the others have none.

    ``lower`` are the pairs of which the test over all problems shows the first one to be lower.
    """
    labels = list(ranks)
    ranking = pd.DataFrame(
        {
            "optimizer": labels,
            "problems": problems,
            "first": [first, *[0] * (len(labels) - 1)],
            "separable": [separable, *[0] * (len(labels) - 1)],
            "worse": [worse, *[problems] * (len(labels) - 1)],
            "mean_rank": list(ranks.values()),
            "place": list(ranks.values()),
        }
    )
    across = {}
    for one, other in permutations(labels, 2):
        ends = (0.75, 0.72, 0.78) if ranks[one] < ranks[other] else (0.25, 0.22, 0.28)
        ends = (0.5, 0.5, 0.5) if ranks[one] == ranks[other] else ends
        across[one, other] = Across(*ends, p=0.004, lower=(one, other) in lower)
    known = {"levels": BOTH, "budget": "60,000 evaluations", "near": "within 1% of the optimum"}
    return Standing(ranking, dict(beaten), across, **(known | more))


def with_pairs(known, **changes):
    """Return the standing with every pair of optimizers changed."""
    return replace(known, across={pair: each._replace(**changes) for pair, each in known.across.items()})


def stages(*lowest):
    """Return the stages at which these, separated by spaces, are shown to end lower than the leader."""
    return [
        Stage(f"{share}%", tuple(each.split())) for share, each in zip((1, 3, 10, 30, 60, 100), lowest, strict=True)
    ]


def near(*shares):
    return pd.Series(dict(zip(THREE, shares, strict=True)))


THREE = {"cma-es": 1.2, "gwo": 2.0, "alo": 2.8}
TWO = {"a": 1.0, "b": 2.0}
LEVEL = {"a": 1.5, "b": 1.5}
SECONDS = {"a": 1.0, "goa": 2.5, "de": 2.5, "gwo": 4.0}
CLEAR = {("cma-es", "gwo"): 15, ("cma-es", "alo"): 18}
SHOWN = {"beaten": CLEAR, "lower": CLEAR}
CLOCK = Clock("gwo", "8.4 us", "gwo is faster by the clock.")
COURSE = [Stage("600", ("gwo",)), Stage("6,000", ("gwo",)), Stage("60,000", ("cma-es",))]
BLIND = {"low": NAN, "high": NAN}
ON_P = standing(TWO, lower={("a", "b")}, problems=1, separable=1, first=1, problem="p", levels=Levels(0.045, 0.045))
UNTESTED = with_pairs(standing(THREE, levels=NONE, trials="1 trial"), **BLIND)
TIED = standing(LEVEL, separable=0)
UNLIKE = {
    "unlike": Differing(
        "handling is box for cma-es",
        "handling differs: set it alike in the study",
        "Controls would add 90 trials.",
    )
}

CASES = {
    "a winner": standing(
        THREE, **SHOWN, near_shares=near(0.43, 0.2, 0.0), course=COURSE, size="Its median is 12% lower.", clock=CLOCK
    ),
    "a winner against all but one": standing(THREE, beaten=CLEAR, lower={("cma-es", "alo")}),
    "a winner, nothing tested on problems": standing(
        THREE, lower=CLEAR, levels=ACROSS, problems=72, separable=0, trials="5 trials"
    ),
    "unlike conditions": standing(THREE, **UNLIKE, **SHOWN),
    "selected": standing(THREE, **SHOWN, selected=True),
    "two not compared": standing(THREE, **SHOWN, left_out=["p", "q"]),
    "three not compared": standing(THREE, **SHOWN, left_out=["p", "q", "r"]),
    "dimensions differ": standing(THREE, **SHOWN, differing="not in dimension 5 (gwo)", worse=3),
    "two on a problem": ON_P,
    "two on a problem, not shown": with_pairs(ON_P, lower=False),
    "one trial": UNTESTED,
    "several share the lead": standing(LEVEL | {"c": 3.0}, beaten={("a", "c"): 18}),
    "all are level": TIED,
    "all are level, on other problems each": replace(TIED, ranking=TIED.ranking.assign(separable=[9, 9])),
    "another comes near the optimum": standing(THREE, near_shares=near(0.0, 0.3, 0.1)),
    "hardly any run comes near": standing(THREE, near_shares=near(0.001, 0.0, 0.0)),
    "no run comes near": standing(THREE, near_shares=near(0.0, 0.0, 0.0)),
    "ahead at every budget": standing(THREE, beaten=CLEAR, course=stages(*["cma-es"] * 6), unit="of the budget"),
    "others ahead at smaller budgets": standing(
        THREE, beaten=CLEAR, course=stages("gwo", "cma-es", "alo", "gwo alo", "cma-es", "cma-es"), unit="of the budget"
    ),
    "two share the second place": standing(SECONDS),
}  # fmt: skip


def test_every_case_says_what_is_committed(committed):
    def text(name, said):
        short = [f"  {line.label}: {line.text}" for line in said.lines]
        return [f"## {name} [{'claim' if said.clear else 'open'}]", said.headline, *short, *said.details, ""]

    committed("verdict-cases", "\n".join(line for name, own in CASES.items() for line in text(name, verdict(own))))


def lines(known):
    return {line.label: line.text for line in verdict(known).lines}


def details(known):
    return " ".join(verdict(known).details)


@pytest.mark.parametrize("second", ["goa", "de"])
def test_optimizers_that_share_the_second_rank_are_all_named(second):
    known, other = CASES["two share the second place"], {"goa": "de", "de": "goa"}[second]
    ordered = known.ranking.set_index("optimizer").loc[["a", second, other, "gwo"]].reset_index()
    assert f"a run of {second}, which shares the second place with {other}," in details(replace(known, ranking=ordered))


@pytest.mark.parametrize("ranks", [THREE, LEVEL | {"c": 3.0}, LEVEL])
@pytest.mark.parametrize("evidence", [SHOWN, {}, {"levels": NONE, "trials": "1 trial"}])
def test_the_first_screen_is_read_at_a_glance(ranks, evidence):
    for conditions, selected, left_out in product(("", "box for cma-es"), (0, 1), ((), ("p", "q"))):
        known = standing(
            ranks, unlike=Differing(conditions, conditions), course=COURSE, clock=CLOCK, worse=3,
            differing="not in dimension 5 (gwo)", selected=bool(selected), left_out=left_out, **evidence,
        )  # fmt: skip
        said = verdict(known)
        assert not left_out or "not compared: p and q" in said.lines[0].text
        assert len(said.headline.split()) <= 25
        assert len(said.lines) <= 4 + bool(conditions)
        assert max(len(line.text.split()) for line in said.lines) <= 20
        assert said.headline.endswith(", under unlike conditions.") == (
            bool(conditions) and len(known.level) < len(ranks)
        )


def test_a_percentage_is_none_or_all_only_where_it_is():
    assert [percent(share) for share in (0.0, 0.001, 0.5, 0.999, 1.0)] == ["0%", "<1%", "50%", ">99%", "100%"]
