"""What the verdict says of budgets, clocks, sweeps and tests across problems, in studies made for it."""

import re

import pandas as pd
import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.verdict import section as verdict


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


def test_ranks_that_no_test_separates_from_the_first_are_marked(make, tmp_path):
    alike = {"b": {"fun": 5.0}, "c": {"fun": 5.0}}
    ranks = verdict.section(Findings(Results(make(tmp_path / "s", trials=8, changes=alike)))).items[1]
    assert set(ranks.marks.to_numpy().ravel()) <= {"", "≈"}
    assert ranks.bold.sum(axis=1).ge(1).all()
    assert not (ranks.bold & (ranks.marks == "≈")).any(axis=None)


def test_where_every_trial_failed_none_finished(make, tmp_path):
    lost = [(problem, optimizer) for problem in "pq" for optimizer in "abc"]
    shown = verdict.section(Findings(Results(make(tmp_path / "s", fail=lost))))
    assert shown.text == ("There is nothing to compare: no trial finished.",)
    assert not shown.cards
    assert shown.lost.startswith("48 of 48 trials did not finish")


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


def size(findings, **medians):
    """Return by how much the verdict says a to be lower than b, whose medians on three problems these are."""
    findings.final.__dict__["medians"] = pd.DataFrame(medians, index=["p", "q", "r"])
    return verdict.standing(findings).size


@pytest.mark.parametrize(
    ("medians", "said"),
    [
        ([61.0, 42.0, 19.0], "58% lower in the median over problems (39% to 81% lower)."),
        ([120.0, 80.0, 42.0], "20% lower in the median over problems (20% higher to 58% lower)."),
        ([100.0, 99.0, 96.6], "1% lower in the median over problems (0% to 3.4% lower)."),
        ([158.0, 130.0, 120.0], "30% higher in the median over problems (20% to 58% higher)."),
        ([94.99, 94.985, 94.98], "5% lower in the median over problems."),
        ([6200.4, 100.0, 0.4], "0% lower in the median over problems (6,100% higher to 100% lower)."),
    ],
)
def test_the_spread_of_the_gain_never_calls_a_higher_median_lower(fresh, medians, said):
    assert size(fresh, a=medians, b=[100.0] * 3) == f"Its median is {said}"


@pytest.mark.parametrize("lowest", [-1e-9, -5.0])
def test_medians_below_zero_have_no_percentage(fresh, lowest):
    assert "%" not in size(fresh, a=[lowest, 2.0, 2.0], b=[1.0, 3.0, 3.0])


@pytest.mark.parametrize(
    ("ratio", "text"), [(1.0, "about as many"), (1.04, "about as many"), (0.994, "only 99% as many"),
                        (1.05, "1.1 times as many"), (12.3, "12 times as many"), (float("inf"), "")]
)  # fmt: skip
def test_no_ratio_of_running_times_is_1_times(findings, ratio, text):
    found = Findings(findings.results, "precisions")
    level, erts = found.anytime.target_set.level, {"a": 100.0, "b": 100.0 * ratio}
    rows = [{"problem": "p", "optimizer": label, "precision": level, "ert": ert} for label, ert in erts.items()]
    found.anytime.__dict__["running_times"] = pd.DataFrame(rows).assign(tau=level, successes=3, ert_s=float("nan"))
    said = verdict.standing(found).size
    assert f", b needs {text} evaluations" in said if text else said == ""
