"""The verdict: headline, lines and details of a winner, of conditions that differ, and where there is no winner."""

from dataclasses import replace
from itertools import permutations

import pandas as pd
import pytest

from bench.analysis import Levels
from bench.report.wording import percent
from bench.topics.verdict.clock import Clock
from bench.topics.verdict.winner import Across, Stage, Standing, verdict

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
    return {line.label: line.text for line in verdict(known).lines}


def details(known):
    return " ".join(verdict(known).details)


THREE = {"cma-es": 1.2, "gwo": 2.0, "alo": 2.8}
CLEAR = {("cma-es", "gwo"): 15, ("cma-es", "alo"): 18}
CLOCK = Clock("gwo", "8.4 us", "gwo is faster by the clock.")
COURSE = [Stage("600", ("gwo",)), Stage("6,000", ("gwo",)), Stage("60,000", ("cma-es",))]


def test_a_winner_in_few_words():
    known = standing(
        THREE, beaten=CLEAR, lower=CLEAR, beyond=CLEAR, near_shares=pd.Series({"cma-es": 0.43, "gwo": 0.2, "alo": 0.0}),
        course=COURSE, size="Its median is 12% lower.", clock=CLOCK,
    )  # fmt: skip
    said = verdict(known)
    assert said.clear
    assert (
        said.headline == "cma-es ends lowest on these 18 problems and on further ones like them at 60,000 evaluations."
    )
    assert lines(known) == {
        "where": "first on 15 of 18, separably lower than every rival on 14",
        "by how much": "a run of cma-es ends lower than one of gwo, the second, in 75% of pairs [72, 78]",
        "how sure": "at most 5% of such pages claim too much; further problems only if independent",
        "at what cost": "gwo ends lower up to 6,000 evaluations; by the clock gwo is faster below 8.4 us an evaluation",
    }
    assert details(known) == (
        "Runs of cma-es end lower than those of all 2 others on these 18 problems (p ≤ 0.004 against each). A run of "
        "cma-es ends lower than a run of gwo with probability 0.75 [0.72, 0.78] on these problems, [0.66, 0.82] on "
        "further ones. Its mean rank is 1.20 [1.10, 1.30] of 3. Its median is 12% lower. 43% of its runs come within "
        "1% of the optimum (gwo 20%). The lead holds for further problems, too, if these are an independent sample of "
        "them. Shown to end lower than cma-es at smaller budgets: gwo from 600 to 6,000 evaluations. gwo is faster by "
        "the clock."
    )


SHOWN = {"beaten": CLEAR, "lower": CLEAR}


@pytest.mark.parametrize("evidence", [SHOWN, SHOWN | {"beyond": CLEAR}, {}, {"levels": NONE, "trials": "1 trial"}])
@pytest.mark.parametrize(
    "conditions", ["", "handling and start are box, midpoint for cma-es and repair for the others"]
)
@pytest.mark.parametrize("ranks", [THREE, {"a": 1.5, "b": 1.5, "c": 3.0}, {"a": 1.5, "b": 1.5}])
@pytest.mark.parametrize("sweep", ["", "18 of 18 problems are steps of one sweep."])
@pytest.mark.parametrize("selected", [False, True])
@pytest.mark.parametrize("left_out", [(), ("p", "q")])
def test_the_first_screen_is_read_at_a_glance(ranks, evidence, conditions, sweep, selected, left_out):
    known = standing(
        ranks, conditions=conditions, sweep=sweep, course=COURSE, clock=CLOCK, worse=3,
        differing="not in dimension 5 (gwo)", selected=selected, left_out=left_out, **evidence,
    )  # fmt: skip
    said = verdict(known)
    assert not left_out or "not compared: p and q" in said.lines[0].text
    assert len(said.headline.split()) <= 25
    assert len(said.lines) <= 4
    assert max(len(line.text.split()) for line in said.lines) <= 20
    assert said.headline.endswith(", under unlike conditions.") == (bool(conditions) and len(known.level) < len(ranks))


def test_a_selection_after_the_results_claims_no_level():
    known = standing(THREE, beaten=CLEAR, lower=CLEAR, selected=True)
    assert lines(known)["how sure"] == "selected after the results, so no level holds; not shown for further problems"


@pytest.mark.parametrize(
    ("left_out", "said"), [(["p", "q"], "; not compared: p and q"), (["p", "q", "r"], "; not compared: 3 problems")]
)
def test_what_is_not_compared_is_named_in_the_first_line(left_out, said):
    found = verdict(standing(THREE, beaten=CLEAR, lower=CLEAR, left_out=left_out))
    assert found.lines[0].text.endswith(said)


def test_with_looks_the_details_name_the_evidence_on_problems():
    on_problems = standing(THREE, beaten=CLEAR, levels=LOOKS, worse=2)
    assert verdict(on_problems).clear
    assert "cma-es is separably lower than each other optimizer on more than half of 18 problems." in details(
        on_problems
    )
    assert lines(on_problems)["where"].endswith("(a rival on 2)")


def test_further_problems_are_claimed_only_where_their_test_shows_them():
    suite = standing(THREE, lower=CLEAR, levels=ACROSS, problems=72, blocks=24, separable=0, trials="5 trials")
    assert "With 5 trials a cell nothing is tested on single problems." in details(suite)
    unsure = "The lead is not shown for further problems, of which these would be a sample of 24 independent problems."
    one = standing(THREE, lower=CLEAR, beyond=[("cma-es", "gwo")], problems=72, blocks=24)
    for known in (suite, one):  # the second: not against every rival
        assert unsure in details(known)
        assert lines(known)["how sure"].endswith("not shown for further problems")
        assert "further" not in verdict(known).headline


def test_a_winner_needs_every_rival_beaten_over_all_problems():
    mixed = standing(THREE, beaten=CLEAR, lower={("cma-es", "alo")})
    assert not verdict(mixed).clear
    assert verdict(mixed).headline == (
        "No winner on these 18 problems at 60,000 evaluations: cma-es is first, but not shown to end lower than gwo."
    )
    assert lines(mixed)["where"] == "first on 15 of 18, separably lower than gwo on 15 and alo on 18"


def test_unlike_conditions_are_in_the_headline_and_leave_the_claim_open():
    known = standing(THREE, conditions="handling is box for cma-es", matched="Controls would add 90 trials.", **SHOWN)
    said = verdict(known)
    assert not said.clear
    assert said.headline == "cma-es ends lowest on these 18 problems at 60,000 evaluations, under unlike conditions."
    assert "The lead may come from the conditions. Controls would add 90 trials." in said.details
    assert lines(known)["how sure"].endswith("unlike conditions may explain the lead")


def test_two_optimizers_on_one_problem():
    known = standing(
        {"a": 1.0, "b": 2.0}, lower={("a", "b")}, problems=1, separable=1, first=1, problem="p",
        levels=Levels(0.045, 0.045),
    )  # fmt: skip
    assert verdict(known).headline == "a ends lowest on p at 60,000 evaluations."
    assert lines(known) == {
        "by how much": "a run of a ends lower than one of b in 75% of pairs [72, 78]",
        "how sure": "at most 5% of such pages claim too much",
    }
    assert "This holds for this problem only." in details(known)
    across = {pair: each._replace(lower=False) for pair, each in known.across.items()}
    assert verdict(replace(known, across=across)).headline == (
        "No winner on p at 60,000 evaluations: a is first, but not shown to end lower than b."
    )


def test_too_few_trials_for_any_test():
    known = standing(THREE, levels=NONE, trials="1 trial", blocks=1)
    across = {pair: each._replace(low=NAN, high=NAN) for pair, each in known.across.items()}
    known = replace(known, ranking=known.ranking.assign(rank_low=NAN), across=across)
    assert verdict(known).headline == (
        "No winner on these 18 problems at 60,000 evaluations: cma-es is first, untested with 1 trial a cell."
    )
    assert lines(known) == {
        "where": "first on 15 of 18", "how sure": "with so few trials the order may be chance"
    }  # fmt: skip
    assert "Its mean rank is 1.20 of 3." in details(known)


def test_several_share_the_lead():
    known = standing({"a": 1.5, "b": 1.5, "c": 3.0}, beaten={("a", "c"): 18})
    assert verdict(known).headline == (
        "No winner on these 18 problems at 60,000 evaluations: a and b share the first place."
    )
    assert "by how much" not in lines(known)


def test_all_are_level():
    tied = standing({"a": 1.5, "b": 1.5}, separable=0)
    headline = "No optimizer leads on these 18 problems at 60,000 evaluations: all are level."
    assert verdict(tied) == (headline, (), (), False)
    conflict = replace(tied, ranking=tied.ranking.assign(separable=[9, 9]))
    assert lines(conflict) == {"where": "problems differ: separably lower than every rival is a on 9 and b on 9"}


def test_runs_near_the_optimum():
    def said(*shares):
        return details(standing(THREE, near_shares=pd.Series(dict(zip(THREE, shares, strict=True)))))

    assert "None of its runs comes within 1% of the optimum, but 30% of gwo’s do." in said(0.0, 0.3, 0.1)
    assert "<1% of its runs come within 1% of the optimum (no other run does)." in said(0.001, 0.0, 0.0)
    assert "within 1% of" not in said(0.0, 0.0, 0.0)


def stages(*lowest):
    """Return the stages at which these, separated by spaces, are shown to end lower than the leader."""
    return [
        Stage(f"{share}%", tuple(each.split())) for share, each in zip((1, 3, 10, 30, 60, 100), lowest, strict=True)
    ]


@pytest.mark.parametrize(
    ("lowest", "short", "whole"),
    [
        (
            ["cma-es"] * 6,
            "none is shown to end lower at smaller budgets",
            "At no smaller budget is another one shown to end lower.",
        ),
        (
            ["gwo", "cma-es", "alo", "alo", "cma-es", "cma-es"],
            "alo ends lower up to 30% of the budget",
            "Shown to end lower than cma-es at smaller budgets: gwo at 1% and alo from 10% to 30% of the budget.",
        ),
    ],
)
def test_who_is_ahead_at_smaller_budgets(lowest, short, whole):
    known = standing(THREE, beaten=CLEAR, course=stages(*lowest), unit="of the budget")
    assert lines(known).get("at what cost") == short
    assert details(known).endswith(whole)


def test_optimizers_that_share_the_second_rank_are_all_named():
    tied = standing({"a": 1.0, "goa": 2.5, "de": 2.5, "gwo": 4.0})
    for second, other in (("goa", "de"), ("de", "goa")):
        ordered = tied.ranking.set_index("optimizer").loc[["a", second, other, "gwo"]].reset_index()
        said = details(replace(tied, ranking=ordered))
        assert f"ends lower than a run of {second}, which shares the second place with {other}, with" in said


def test_a_sweep_speaks_for_no_further_problems():
    known = standing(THREE, lower=CLEAR, beyond=CLEAR, sweep="18 of 18 problems are steps of one sweep.", blocks=1)
    assert lines(known)["how sure"].endswith("these problems are one sweep")
    assert "further" not in f"{verdict(known).headline}{details(known)}"
    assert "18 of 18 problems are steps of one sweep." in details(known)


def test_a_percentage_is_none_or_all_only_where_it_is():
    assert [percent(share) for share in (0.0, 0.001, 0.5, 0.999, 1.0)] == ["0%", "<1%", "50%", ">99%", "100%"]


def test_effects_that_looks_biased_are_not_given():
    known = standing(THREE, beaten=CLEAR, levels=LOOKS)
    across = {pair: Across(NAN, NAN, NAN, (NAN, NAN), each.p, each.lower) for pair, each in known.across.items()}
    said = verdict(replace(known, across=across))
    assert "by how much" not in {line.label for line in said.lines}
    assert "probability" not in " ".join(said.details)
    assert said.headline.startswith("cma-es ends lowest")
