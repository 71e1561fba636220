"""The paragraph on the winner: margin, certainty and budget, and the sentences where there is no winner."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from scipy.stats import wilcoxon

from bench.report.winner import Stage, Standing, paragraph, percent, too_few_problems

NAN = float("nan")


def standing(ranks, *, beaten=(), problems=18, first=(15, 13, 17), separable=14, worse=0, leads=1.0, **more):
    """Return the standing of optimizers by mean rank; the first has the numbers given, the others have none."""
    labels = list(ranks)
    ranking = pd.DataFrame(
        {
            "optimizer": labels,
            "problems": problems,
            "first": [first[0], *[0] * (len(labels) - 1)],
            "separable": [separable, *[0] * (len(labels) - 1)],
            "worse": [worse, *[problems] * (len(labels) - 1)],
            "mean_rank": list(ranks.values()),
            "first_low": [float(first[1]), *[0.0] * (len(labels) - 1)],
            "first_high": [float(first[2]), *[0.0] * (len(labels) - 1)],
            "leads": [leads, *[0.0] * (len(labels) - 1)],
        }
    )
    chances = {
        (one, other): (0.75, 0.72, 0.78) if ranks[one] < ranks[other] else (0.25, 0.22, 0.28)
        for one, other in permutations(labels, 2)
    }
    chances |= {pair: (0.5, 0.5, 0.5) for pair in chances if ranks[pair[0]] == ranks[pair[1]]}
    known = {"testable": True, "budget": "60,000 evaluations", "near": "within 1% of the optimum"} | more
    return Standing(ranking, dict(beaten), chances, **known)


THREE = {"cma-es": 1.2, "gwo": 2.0, "alo": 2.8}
CLEAR = {("cma-es", "gwo"): 15, ("cma-es", "alo"): 18}


def test_a_winner_as_a_paper_prints_it():
    known = standing(
        THREE, beaten=CLEAR, found=pd.Series({"cma-es": 0.43, "gwo": 0.2, "alo": 0.0}),
        course=[Stage("600", ("gwo",)), Stage("6,000", ("gwo",)), Stage("60,000", ("cma-es",))],
    )  # fmt: skip
    assert paragraph(known) == (
        "cma-es is best at 60,000 evaluations: separably lower than all 2 others on 14 of 18 problems, and "
        "significantly worse on none. It is ranked first on 15 [13, 17] of 18, and would lead in practically every "
        "repetition of these trials. A run of it beats a run of gwo, the second in rank, with probability 0.75 "
        "[0.72, 0.78]. 43% of its runs come within 1% of the optimum (gwo 20%). At smaller budgets the lowest "
        "mean rank is that of gwo from 600 to 6,000 evaluations."
    )


def test_a_winner_that_loses_somewhere_and_seldom_wins_at_once():
    text = paragraph(standing(THREE, beaten=CLEAR, separable=5, worse=2, leads=0.81))
    assert text.startswith(
        "cma-es is best at 60,000 evaluations: separably lower than each other optimizer on more than half of 18 "
        "problems, than all 2 others at once on 5, and significantly worse than another on 2."
    )
    assert "would lead in 81% of repetitions of these trials" in text


def test_two_optimizers_on_one_problem():
    known = standing(
        {"a": 1.0, "b": 2.0}, beaten={("a", "b"): 1}, problems=1, separable=1, first=(1, 1, 1), problem="p"
    )
    assert paragraph(known) == (
        "a is best on p at 60,000 evaluations: its results are separably lower than those of b. This holds for this "
        "problem only. A run of it beats a run of b with probability 0.75 [0.72, 0.78]."
    )
    assert paragraph(replace(known, beaten={})).startswith(
        "No single winner at 60,000 evaluations: a ranks first on p, but is not separably lower than b. This"
    )


def test_no_winner_without_a_majority_of_separable_problems():
    text = paragraph(standing(THREE, beaten={("cma-es", "gwo"): 9, ("cma-es", "alo"): 18}, worse=3))
    assert text.startswith(
        "No single winner at 60,000 evaluations: cma-es has the lowest mean rank over 18 problems (1.20 of 3), but is "
        "separably lower on at most half of the problems than gwo (9). On 3 problems another one is separably lower "
        "than it. It is ranked first"
    )


def test_too_few_trials_for_any_test():
    known = standing(THREE, testable=False, trials="1 trial", found=pd.Series({"cma-es": 1.0, "gwo": 0.0, "alo": 0.0}))
    text = paragraph(replace(known, ranking=known.ranking.assign(first_low=NAN)))
    assert text == (
        "No winner can be named at 60,000 evaluations: with 1 trial a cell no test can be significant. cma-es has the "
        "lowest mean rank over 18 problems (1.20 of 3), which may be chance. A run of it beats a run of gwo, the "
        "second in rank, with probability 0.75 [0.72, 0.78]."
    )


def test_several_share_the_lead():
    text = paragraph(standing({"a": 1.5, "b": 1.5, "c": 3.0}, beaten={("a", "c"): 18}))
    assert text == "No single winner at 60,000 evaluations: a and b share the lowest mean rank over 18 problems."


def test_all_are_level():
    tied = standing({"a": 1.5, "b": 1.5}, separable=0)
    said = "No optimizer leads at 60,000 evaluations: all have the same mean rank over 18 problems."
    assert paragraph(tied) == said
    conflict = replace(tied, ranking=tied.ranking.assign(separable=[9, 9]))
    assert paragraph(conflict) == f"{said} But problems differ: separably lower than every rival is a on 9 and b on 9."


def test_runs_near_the_optimum():
    def said(*shares):
        return paragraph(standing(THREE, beaten=CLEAR, found=pd.Series(dict(zip(THREE, shares, strict=True)))))

    assert "None of its runs comes within 1% of the optimum, but 30% of gwo’s do." in said(0.0, 0.3, 0.1)
    assert "<1% of its runs come within 1% of the optimum (no other run does)." in said(0.001, 0.0, 0.0)
    assert "within 1% of" not in said(0.0, 0.0, 0.0)


def stages(*lowest):
    """Return the stages at which these, separated by spaces, have the lowest mean rank."""
    return [
        Stage(f"{share}%", tuple(each.split())) for share, each in zip((1, 3, 10, 30, 60, 100), lowest, strict=True)
    ]


@pytest.mark.parametrize(
    ("lowest", "said"),
    [
        (["cma-es"] * 6, "From 1% of the budget on, no other has a lower mean rank."),
        (["cma-es gwo", *["cma-es"] * 5], "From 1% of the budget on, no other has a lower mean rank."),
        (
            ["gwo", "gwo cma-es", "alo", "alo", "cma-es", "cma-es"],
            "the lowest mean rank is that of gwo at 1% and alo from 10% to 30% of the budget.",
        ),
        (
            ["cma-es", "alo gwo", "alo", "cma-es", "alo", "cma-es"],
            "that of alo and gwo at 3%, alo at 10% and alo at 60% of the budget.",
        ),
        (["cma-es"] * 5 + ["gwo"], ""),
    ],
)
def test_who_is_ahead_at_smaller_budgets(lowest, said):
    text = paragraph(standing(THREE, beaten=CLEAR, course=stages(*lowest), unit="of the budget"))
    assert text.endswith(said)
    assert ("lowe" in text.rpartition("probability")[2]) == bool(said)


def test_optimizers_that_share_the_second_rank_are_all_named():
    tied = standing(
        {"a": 1.0, "goa": 2.5, "de": 2.5, "gwo": 4.0}, beaten={("a", each): 18 for each in ("goa", "de", "gwo")}
    )
    for second, other in (("goa", "de"), ("de", "goa")):
        ahead = replace(tied, chances=tied.chances | {(second, "gwo"): (0.9, 0.8, 1.0)})
        assert f"beats a run of {second}, which shares the second rank with {other}, with" in paragraph(ahead)


def test_few_problems_limit_the_claim_in_the_paragraph_itself():
    limit = "This holds for these {} problems only: they are too few for a test across problems to distinguish any two"
    for count in (2, 5, 6, 18):
        text = paragraph(standing(THREE, beaten=dict.fromkeys(CLEAR, count), problems=count, separable=count))
        assert (limit.format(count) in text) == (count <= 6)
        assert " is best " in text
    assert limit.format(2) in paragraph(standing(THREE, problems=2, testable=False, trials="2 trials"))


@pytest.mark.parametrize("pairs", [1, 3, 10])
def test_problems_are_too_few_where_differences_of_one_sign_are_not_significant(pairs):
    for problems in range(1, 14):
        p = wilcoxon(np.arange(1.0, problems + 1), method="exact").pvalue
        assert too_few_problems(problems, pairs) == (p * pairs > 0.05)


def test_a_percentage_is_none_or_all_only_where_it_is():
    assert [percent(share) for share in (0.0, 0.001, 0.5, 0.999, 1.0)] == ["0%", "<1%", "50%", ">99%", "100%"]


def test_a_single_trial_leaves_no_interval():
    known = standing(THREE, beaten=CLEAR)
    chances = {pair: (chance, np.nan, np.nan) for pair, (chance, _, _) in known.chances.items()}
    assert "with probability 0.75." in paragraph(replace(known, chances=chances))
