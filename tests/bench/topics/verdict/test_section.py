"""What the verdict says of budgets, clocks, sweeps and tests across problems, in studies made for it."""

import re
from dataclasses import replace

import pandas as pd
import pytest

from bench import Results
from bench.topics.anytime.section import course
from bench.topics.findings import Findings
from bench.topics.ranks import section as across
from bench.topics.verdict import section as verdict
from bench.topics.verdict.winner import PARTS


@pytest.fixture(scope="module")
def findings(make, tmp_path_factory):
    return Findings(Results(make(tmp_path_factory.mktemp("verdict") / "s", ("p", "q", "r"))))


@pytest.fixture
def fresh(findings):
    return Findings(findings.results)


def test_the_places_are_the_order_of_every_sentence(findings, fresh):
    final = fresh.final
    other = final.ranking.set_index("optimizer").assign(place=pd.Series({"a": 1.0, "b": 3.0, "c": 2.0}))
    vars(final).update(ranking=other.reset_index())  # in place of what it computed
    assert final.ranked == ["a", "c", "b"]
    known = verdict.standing(fresh)
    assert known.labels == final.ranked
    assert known.size != verdict.standing(findings).size  # of a and b


def test_the_first_screen(findings):
    shown = verdict.section(findings)
    assert [card.title for card in shown.cards] == [
        "",
        "The numbers behind it",
        "What may not be claimed",
        "How often would this page be wrong?",
        "How this is decided",
    ]
    assert [card.folded for card in shown.cards] == [False, True, True, True, True]
    lines = shown.cards[0].lines
    assert [line.label for line in lines][:3] == ["where", "by how much", "how sure"]
    assert {line.part for line in lines} <= {card.title for card in shown.cards} | {across.TITLE, *PARTS.values()}
    assert [item.name for item in shown.items] == ["every-trial", "rank-map"]
    ranks = shown.items[1]
    assert ranks.cells["p", "b"] == ("p", "b")
    assert ranks.frame.to_numpy().tolist() == [["1", "2", "3"]] * 3
    assert ranks.shades.iloc[0].tolist() == [0.0, 0.5, 1.0]


def test_the_ranking_stands_with_the_tests_over_all_problems(findings):
    ranking = across.section(findings).items[0]
    assert ranking.frame["first"].tolist() == [3, 0, 0]
    assert ranking.frame["mean rank"].tolist() == ["1.00 [1.00, 1.00]", "2.00 [2.00, 2.00]", "3.00 [3.00, 3.00]"]


def test_separably_lower_is_explained_where_the_claim_says_it(make, tmp_path):
    one = verdict.section(Findings(Results(make(tmp_path / "s", problems=("p", "q"), trials=12))))
    assert "separably lower" in f"{one.cards[0].lines}"
    assert verdict.SEPARABLY in one.cards[1].text
    few = verdict.section(Findings(Results(make(tmp_path / "t", trials=1))))
    assert "separably" not in f"{few.cards[0]}{few.cards[1]}"


def test_ranks_that_no_test_separates_from_the_first_are_marked(make, tmp_path):
    alike = {"b": {"fun": 5.0}, "c": {"fun": 5.0}}
    ranks = verdict.section(Findings(Results(make(tmp_path / "s", trials=8, changes=alike)))).items[1]
    assert set(ranks.marks.to_numpy().ravel()) <= {"", "≈"}
    assert ranks.bold.sum(axis=1).ge(1).all()
    assert not (ranks.bold & (ranks.marks == "≈")).any(axis=None)


def test_no_rank_is_marked_where_nothing_is_tested(make, tmp_path):
    ranks = verdict.section(Findings(Results(make(tmp_path / "s", trials=3)))).items[1]
    assert set(ranks.marks.to_numpy().ravel()) == {""}


def test_where_every_trial_failed_none_finished(make, tmp_path):
    lost = [(problem, optimizer) for problem in "pq" for optimizer in "abc"]
    shown = verdict.section(Findings(Results(make(tmp_path / "s", fail=lost))))
    assert shown.text == ("There is nothing to compare: no trial finished.",)
    assert not shown.cards
    assert shown.lost.startswith("48 of 48 trials did not finish")


def test_which_p_values_are_adjusted_is_said(findings):
    said = " ".join(verdict.section(findings).cards[1].text)
    assert "adjusted by Holm’s method over pairs, and on single problems over these, too; those of a winner are" in said


def test_one_test_is_not_many(make, tmp_path):
    found = Findings(Results(make(tmp_path / "s", ("p",), ("a", "b"), trials=3)))
    said = " ".join(verdict.section(found).cards[4].text)
    assert "with 3 trials a cell no test on a problem could, so none is made here" in said
    assert "so many tests" not in said


def test_one_trial_has_no_intervals_and_no_winner(make, tmp_path):
    shown = verdict.section(Findings(Results(make(tmp_path / "s", trials=1))))
    assert shown.cards[0].text[0].endswith("at 100 evaluations: a is first, untested with 1 trial a cell.")


def test_steps_of_one_sweep_are_no_independent_sample(fresh):
    assert verdict.dependent(fresh) == ""
    fresh.trials.__dict__.pop("sweeps"), fresh.trials.__dict__.pop("blocks", None)
    fresh.trials.__dict__["known"] = {
        label: replace(each, features={"sweep": "the load"}) for label, each in fresh.trials.known.items()
    }
    said = verdict.dependent(fresh)
    assert said == (
        "3 of 3 problems are steps of one sweep, the load: they are 1 independent problem, so the counts describe this "
        "sweep and no further problems."
    )
    claim, numbers = verdict.section(fresh).cards[:2]
    assert said in numbers.text
    assert "these problems are one sweep" in f"{claim.lines}"
    assert said in across.section(fresh).text


def test_pairs_that_the_tests_do_not_separate_are_named(fresh):
    said = verdict.across(fresh)
    assert said == "Every pair of optimizers differs significantly on these problems, but not on each of them."
    assert said in across.section(fresh).text[0]
    assert said in verdict.section(fresh).cards[2].text


def test_where_no_pair_is_distinguished_none_is_listed(fresh):
    fresh.final.__dict__["overall"] = fresh.final.overall.assign(significant=False)
    assert verdict.across(fresh) == "On these problems the tests distinguish no two optimizers (Holm)."
    fresh.final.__dict__["overall"] = fresh.final.overall.assign(significant=[True, False, False])
    assert verdict.across(fresh) == "On these problems the tests do not distinguish a from c and b from c (Holm)."


def test_the_page_prints_how_often_it_would_be_wrong(fresh):
    text = verdict.section(fresh).cards[3].text
    assert text[0].startswith("How often a page of this design (3 optimizers, 3 problems, 8 trials a cell) claims any")
    for sentence in text[1:3]:
        assert float(re.search(r": <?(\d+)% of 1,000 simulated studies", sentence)[1]) <= 7
    assert "would often miss an A12 below" in text[3]


def test_unused_budget_is_said_with_its_share(make, tmp_path):
    changes = {"a": {"nfev": 60, "stop": "tolfun"}}
    found = Findings(Results(make(tmp_path / "s", trials=4, changes=changes)))
    limits = verdict.section(found).cards[2].text
    assert any(text.startswith("A part of the budget was left unused (mean share): a 40%.") for text in limits)
    whole = Findings(Results(make(tmp_path / "t", trials=4)))
    assert not any("left unused" in text for text in verdict.section(whole).cards[2].text)


def test_smaller_budgets_are_the_points_of_the_figure_and_who_leads_there_is_tested(fresh):
    (figure,) = course(fresh)
    first, *_, last = verdict._course(fresh)
    assert [first.spent, last.spent] == [f"{at:,}" for at in (figure.shown.index[0], figure.shown.index[-1])]
    leads = pd.DataFrame({"share": [0.01, 0.03], "optimizer": "b", "shown": [True, False]})
    fresh.anytime.__dict__["earlier_leads"] = lambda leader, level: leads
    assert [each.lowest for each in verdict._course(fresh)] == [("b",), *[("a",)] * 5]


@pytest.mark.parametrize(
    ("ends", "shown"),
    [((39, 81), " (39% to 81% lower)"), ((-20, 58), " (20% higher to 58% lower)"), ((0, 3.4), " (0% to 3.4% lower)"),
     ((-58, -20), " (20% to 58% higher)"), ((5.01, 5.02), ""), ((-5, 5), " (5% higher to 5% lower)"), ((0, 0), "")],
)  # fmt: skip
def test_the_spread_of_the_gain_never_calls_a_higher_median_lower(ends, shown):
    assert verdict._spread(*ends) == shown


@pytest.mark.parametrize(
    ("ratio", "text"), [(1.0, "about as many"), (1.04, "about as many"), (0.994, "only 99% as many"),
                        (1.05, "1.1 times as many"), (12.3, "12 times as many")]
)  # fmt: skip
def test_no_ratio_of_running_times_is_1_times(ratio, text):
    assert verdict._times(ratio) == text


@pytest.mark.parametrize(
    ("value", "text"), [(99.6, "100"), (-6100.4, "6,100"), (3.44, "3.4"), (0.0, "0"), (-99.4, "99")]
)
def test_percentages_are_written_in_digits_alone(value, text):
    assert verdict._figure(value) == text


@pytest.mark.parametrize("lowest", [0.0, -1e-9, -5.0])
def test_medians_at_or_below_zero_have_no_percentage(fresh, lowest):
    fresh.final.__dict__["medians"] = pd.DataFrame({"a": [lowest, 2.0], "b": [1.0, 3.0]}, index=["p", "q"])
    fresh.anytime.__dict__["running_times"] = pd.DataFrame()
    assert "%" not in verdict._size(fresh)
