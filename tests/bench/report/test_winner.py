"""The verdict: headline and lines of a winner, of conditions that differ, and where there is no winner."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pandas as pd
import pytest

from bench.analysis import Levels
from bench.report.winner import Across, Stage, Standing, verdict
from bench.report.wording import percent

NAN = float("nan")
BOTH, LOOKS, ACROSS, NONE = Levels(0.01, 0.035, 0.005), Levels(0.05, 0.0), Levels(0.0, 0.045), Levels(0.0, 0.0)


def standing(ranks, *, beaten=(), lower=(), beyond=(), problems=18, first=15, separable=14, worse=0, **more):
    """Return the standing of optimizers by mean rank; the first has the numbers given, the others have none.

    ``lower`` are the pairs of which the test over all problems shows the first one to be lower, and ``beyond`` those of
    which that for further ones does.
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
            "rank_low": [each - 0.1 for each in ranks.values()],
            "rank_high": [each + 0.1 for each in ranks.values()],
        }
    )
    across = {}
    for one, other in permutations(labels, 2):
        ends = (0.75, 0.72, 0.78, (0.66, 0.82)) if ranks[one] < ranks[other] else (0.25, 0.22, 0.28, (0.18, 0.34))
        ends = (0.5, 0.5, 0.5, (0.4, 0.6)) if ranks[one] == ranks[other] else ends
        across[one, other] = Across(*ends, p=0.004, lower=(one, other) in lower, beyond=(one, other) in beyond)
    known = {"levels": BOTH, "blocks": problems, "budget": "60,000 evaluations", "near": "within 1% of the optimum"}
    return Standing(ranking, dict(beaten), across, **(known | more))


def lines(known):
    return dict(verdict(known).lines)


THREE = {"cma-es": 1.2, "gwo": 2.0, "alo": 2.8}
CLEAR = {("cma-es", "gwo"): 15, ("cma-es", "alo"): 18}


def test_a_winner_as_a_paper_prints_it():
    known = standing(
        THREE, beaten=CLEAR, lower=CLEAR, beyond=CLEAR, near_shares=pd.Series({"cma-es": 0.43, "gwo": 0.2, "alo": 0.0}),
        course=[Stage("600", ("gwo",)), Stage("6,000", ("gwo",)), Stage("60,000", ("cma-es",))],
        size="Its median is 12% lower.", clock="gwo is faster by the clock.",
    )  # fmt: skip
    said = verdict(known)
    assert said.clear
    assert said.headline == (
        "cma-es is best at 60,000 evaluations: its runs end lower than those of all 2 others on these 18 problems "
        "(p ≤ 0.004 against each)."
    )
    assert lines(known) == {
        "Where": "cma-es: ranked first on 15 of 18; separably lower than every rival on 14; no rival is separably "
        "lower on any.",
        "By how much": "A run of cma-es beats a run of gwo, the second, with probability 0.75 [0.72, 0.78] on these "
        "problems, [0.66, 0.82] on further ones. Its median is 12% lower. 43% of its runs come within "
        "1% of the optimum (gwo 20%).",
        "How sure": "Mean rank 1.20 [1.10, 1.30] of 3. It holds for further problems, too, if these are an "
        "independent sample of them.",
        "At what budget": "Shown to end lower than cma-es at smaller budgets: gwo from 600 to 6,000 evaluations. gwo "
        "is faster by the clock.",
    }


def test_with_looks_the_headline_names_the_evidence_on_problems():
    on_problems = verdict(standing(THREE, beaten=CLEAR, levels=LOOKS, worse=2))
    assert on_problems.headline.endswith("separably lower than each other optimizer on more than half of 18 problems.")
    assert dict(on_problems.lines)["Where"].endswith("a rival is separably lower on 2.")


def test_further_problems_are_claimed_only_where_their_test_shows_them():
    suite = standing(THREE, lower=CLEAR, levels=ACROSS, problems=72, blocks=24, separable=0, trials="5 trials")
    assert "With 5 trials a cell nothing is tested on single problems." in lines(suite)["How sure"]
    unsure = "It is not shown for further problems, of which these would be a sample of 24 independent problems."
    assert unsure in lines(suite)["How sure"]
    one = standing(THREE, lower=CLEAR, beyond=[("cma-es", "gwo")], problems=72, blocks=24)
    assert unsure in lines(one)["How sure"]  # not against every rival


def test_a_winner_needs_every_rival_beaten_over_all_problems():
    mixed = standing(THREE, beaten=CLEAR, lower={("cma-es", "alo")})
    assert not verdict(mixed).clear
    assert verdict(mixed).headline.endswith("but is not shown to be lower than gwo.")


@pytest.mark.parametrize("evidence", [{"beaten": CLEAR, "lower": CLEAR}, {"levels": NONE, "trials": "1 trial"}, {}])
def test_conditions_come_before_the_verb_and_withhold_best(evidence):
    known = standing(
        THREE, conditions="handling is box for cma-es", matched="Controls would add 90 trials.", **evidence
    )
    said = verdict(known)
    assert not said.clear
    assert " best " not in said.headline
    assert said.headline.index("(handling is box for cma-es)") < said.headline.index(
        "cma-es ends" if evidence.get("lower") else "cma-es is first"
    )
    assert "The lead may come from the conditions. Controls would add 90 trials." in lines(known)["How sure"]


def test_two_optimizers_on_one_problem():
    known = standing(
        {"a": 1.0, "b": 2.0}, lower={("a", "b")}, problems=1, separable=1, first=1, problem="p",
        levels=Levels(0.045, 0.045),
    )  # fmt: skip
    said = verdict(known)
    assert said.headline == "a is best on p at 60,000 evaluations: its results are separably lower than those of b."
    assert lines(known)["Where"] == "This holds for this problem only."
    assert lines(known)["By how much"].startswith("A run of a beats a run of b with probability 0.75 [0.72, 0.78]")
    across = {pair: each._replace(lower=False) for pair, each in known.across.items()}
    assert verdict(replace(known, across=across)).headline == (
        "No single winner at 60,000 evaluations: a ranks first on p, but is not shown to be lower than b."
    )


def test_no_single_winner_counts_rivals_problem_by_problem():
    known = standing(THREE, beaten={("cma-es", "gwo"): 9, ("cma-es", "alo"): 18}, lower={("cma-es", "alo")}, worse=3)
    assert verdict(known).headline == (
        "No single winner at 60,000 evaluations: cma-es is first over 18 problems, but is not shown to be lower than "
        "gwo."
    )
    assert lines(known)["Where"] == (
        "cma-es: ranked first on 15 of 18; separably lower than gwo 9 and alo 18; a rival is separably lower on 3."
    )


def test_too_few_trials_for_any_test():
    known = standing(
        THREE, levels=NONE, trials="1 trial", blocks=1, near_shares=pd.Series({"cma-es": 1.0, "gwo": 0.0, "alo": 0.0})
    )
    across = {pair: each._replace(low=NAN, high=NAN) for pair, each in known.across.items()}
    known = replace(known, ranking=known.ranking.assign(rank_low=NAN), across=across)
    assert verdict(known).headline == (
        "No winner can be named at 60,000 evaluations: with 1 trial a cell on 1 independent problem no test can be "
        "significant. cma-es is first over 18 problems, which may be chance."
    )
    assert "By how much" not in lines(known)
    assert "At what budget" not in lines(known)
    assert lines(known)["How sure"].startswith("Mean rank 1.20 of 3.")


def test_several_share_the_lead():
    said = verdict(standing({"a": 1.5, "b": 1.5, "c": 3.0}, beaten={("a", "c"): 18}))
    assert said.headline == "No single winner at 60,000 evaluations: a and b share the first place over 18 problems."
    assert "By how much" not in dict(said.lines)


def test_all_are_level():
    tied = standing({"a": 1.5, "b": 1.5}, separable=0)
    headline = "No optimizer leads at 60,000 evaluations: all are level over 18 problems."
    assert verdict(tied) == (headline, (), False)
    conflict = replace(tied, ranking=tied.ranking.assign(separable=[9, 9]))
    assert lines(conflict) == {"Where": "Problems differ: separably lower than every rival is a on 9 and b on 9."}


def test_runs_near_the_optimum():
    def said(*shares):
        return lines(standing(THREE, near_shares=pd.Series(dict(zip(THREE, shares, strict=True)))))["By how much"]

    assert "None of its runs comes within 1% of the optimum, but 30% of gwo’s do." in said(0.0, 0.3, 0.1)
    assert "<1% of its runs come within 1% of the optimum (no other run does)." in said(0.001, 0.0, 0.0)
    assert "within 1% of" not in said(0.0, 0.0, 0.0)


def stages(*lowest):
    """Return the stages at which these, separated by spaces, are shown to end lower than the leader."""
    return [
        Stage(f"{share}%", tuple(each.split())) for share, each in zip((1, 3, 10, 30, 60, 100), lowest, strict=True)
    ]


@pytest.mark.parametrize(
    ("lowest", "said"),
    [
        (["cma-es"] * 6, "At no smaller budget is another one shown to end lower."),
        (["cma-es gwo", *["cma-es"] * 5], "At no smaller budget is another one shown to end lower."),
        (
            ["gwo", "gwo cma-es", "alo", "alo", "cma-es", "cma-es"],
            "Shown to end lower than cma-es at smaller budgets: gwo at 1% and alo from 10% to 30% of the budget.",
        ),
        (
            ["cma-es", "alo gwo", "alo", "cma-es", "alo", "cma-es"],
            (
                "Shown to end lower than cma-es at smaller budgets: alo and gwo at 3%, alo at 10% and alo at 60% of "
                "the budget."
            ),
        ),
        (["cma-es"] * 5 + ["gwo"], None),
    ],
)
def test_who_is_ahead_at_smaller_budgets(lowest, said):
    known = standing(THREE, beaten=CLEAR, course=stages(*lowest), unit="of the budget")
    assert lines(known).get("At what budget") == said


def test_optimizers_that_share_the_second_rank_are_all_named():
    tied = standing({"a": 1.0, "goa": 2.5, "de": 2.5, "gwo": 4.0})
    for second, other in (("goa", "de"), ("de", "goa")):
        ordered = tied.ranking.set_index("optimizer").loc[["a", second, other, "gwo"]].reset_index()
        said = lines(replace(tied, ranking=ordered))["By how much"]
        assert f"beats a run of {second}, which shares the second place with {other}, with" in said


def test_a_sweep_speaks_for_no_further_problems():
    known = standing(THREE, lower=CLEAR, beyond=CLEAR, sweep="18 of 18 problems are steps of one sweep.", blocks=1)
    assert lines(known)["How sure"] == "Mean rank 1.20 [1.10, 1.30] of 3. 18 of 18 problems are steps of one sweep."


def test_a_percentage_is_none_or_all_only_where_it_is():
    assert [percent(share) for share in (0.0, 0.001, 0.5, 0.999, 1.0)] == ["0%", "<1%", "50%", ">99%", "100%"]


def test_effects_that_looks_biased_are_not_given():
    known = standing(THREE, beaten=CLEAR, levels=LOOKS)
    across = {pair: Across(NAN, NAN, NAN, (NAN, NAN), each.p, each.lower) for pair, each in known.across.items()}
    said = verdict(replace(known, across=across))
    assert "By how much" not in dict(said.lines)
    assert said.headline.startswith("cma-es is best")
    assert np.isfinite(known.across["cma-es", "gwo"].chance)
