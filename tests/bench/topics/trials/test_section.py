"""What a report says of the number of trials: what looks decided, what would be needed, and undeclared extensions."""

from dataclasses import replace

import pandas as pd
import pytest

from bench import Results
from bench.storage.folder import Folder
from bench.topics.findings import Findings
from bench.topics.integrity import section as integrity
from bench.topics.integrity.checks import checks
from bench.topics.methods import section as methods
from bench.topics.trials import section as trials
from bench.topics.verdict import section as verdict


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    """b and c are equal and far above a, on both problems."""
    return make(tmp_path_factory.mktemp("trials") / "s", trials=12, changes={"c": {"fun": 6.0}, "b": {"fun": 6.0}})


def findings_of(folder, looks=(), records=()):
    results = Results(folder)
    results.study = replace(results.study, looks=looks)
    results.environments[:] = records
    return Findings(results)


def test_pairs_that_are_not_separated(folder):
    found = trials.section(findings_of(folder))
    assert found.text[0].startswith("2 pairs are not separated. With a power of 80%, all 2 would need more than 1,000:")
    assert found.text[1] == trials.CAUTION
    assert [item.name for item in found.items] == ["trials-needed", "stability"]
    shown = found.items[0].frame
    assert (
        shown[["first", "second", "trials", "needed", "more"]].to_numpy().tolist() == [["b", "c", 12, ">1,000", ""]] * 2
    )


def test_looks(folder):
    known = findings_of(folder, looks=(6, 10, 12))
    assert set(known.trials.decisions.stopped) == {("p", "a"), ("q", "a")}
    found = trials.section(known)
    assert found.text[0].startswith("The study declares looks at 6, 10 and 12 trials: at each, the pairs of a problem")
    assert "Of 6 cells, 2 at 10 trials were stopped early" in found.text[0]
    table = found.items[0].frame
    assert table["cells decided"].tolist() == [0, 2, 0]
    assert table.index.tolist() == [6, 10, 12]
    assert set(known.final.pairs["look"]) == {0, 10}
    shown = verdict.section(known)
    assert trials.NOT_ADJUSTED in shown.cards[2].text
    adjusted = "adjusted for looks at 6, 10 and 12 trials and by Holm’s method over the 6 pairs of all problems"
    assert adjusted in shown.cards[4].text[0]
    assert "2 cells were decided against every rival" in " ".join(methods.section(known).text)
    plain = verdict.section(findings_of(folder))
    assert "looks" not in str(plain.cards)


def test_a_cell_that_a_look_stopped_is_complete(folder):
    known = findings_of(folder, looks=(6, 10, 12))
    missing = known.results.frame[~((known.results.frame["optimizer"] == "a") & (known.results.frame["trial"] >= 10))]
    for looks, verdicts in (((6, 10, 12), "pass"), ((), "warning")):
        own = findings_of(folder, looks)
        own.results.__dict__["_frame_and_origins"] = (missing.reset_index(drop=True), pd.Series([1] * len(missing)))
        made = own.of(checks).set_index("check")
        assert made.loc["completeness", "verdict"] == verdicts
        assert own.trials.coverage["missing"].sum() == (0 if looks else 4)


def test_looks_that_are_not_reached(folder):
    known = findings_of(folder, looks=(20, 30))
    assert "Not even the first look is complete on 2 problems." in trials.section(known).text[0]
    assert "None of the 6 cells was stopped early" in trials.section(known).text[0]
    assert not known.final.pairs["significant"].any()


def test_trials_that_were_added_to_complete_ones(folder):
    record = {"trials": 12, "extends": 8, "packages": {}}
    known = findings_of(folder, records=[{"trials": 8, "extends": None}, record, record])
    assert known.trials.extensions == [(8, 12)]
    sentence = trials.section(known).text[0]
    assert sentence.startswith(
        "Optional stopping: 8 trials of each cell were complete, and could be looked at, when 12"
    )
    assert sentence in verdict.section(known).cards[2].text
    assert sum(each.startswith("Optional stopping: Trials were added") for each in integrity.warnings(known)) == 1
    assert "this is optional stopping" in " ".join(methods.section(known).text)
    early = findings_of(folder, records=[{"trials": 12, "extends": 3}, {"started": "of an older version"}])
    assert trials.extension_text(early) == []
    assert findings_of(folder, looks=(8, 12), records=[record]).trials.extensions == []


def test_nothing_to_compare(make, tmp_path):
    for cells in ({"optimizers": ("a",)}, {"skip": [("p", "b"), ("q", "b")], "optimizers": ("a", "b")}):
        found = trials.section(Findings(Results(make(tmp_path / str(len(cells)), **cells))))
        assert (found.text, found.items) == (
            ("There is nothing to compare, so no number of trials can be judged.",),
            (),
        )


def test_all_pairs_are_separated(make, tmp_path):
    found = trials.section(Findings(Results(make(tmp_path / "s", trials=12))))
    assert found.text == ("All 6 pairs are separated.",)
    assert [item.name for item in found.items] == ["stability"]


@pytest.mark.parametrize(
    ("needed", "sentence"),
    [
        ([40.0], "1 pair is not separated. With a power of 90%, 40 trials of each optimizer would separate it."),
        ([float("inf")], "1 pair is not separated. With a power of 90%, it would need more than 1,000:"),
        ([float("nan")], "nothing can be said of it, with fewer than two trials in a cell"),
        (
            [40.0, 90.0, float("inf")],
            "40 to 90 trials of each optimizer would separate 2 of them; 1 of them would need",
        ),
    ],
)
def test_sentences(needed, sentence):
    table = pd.DataFrame({"needed": needed, "method": "simulation"})
    assert sentence in trials.summary(table, 9, 0.9)[0]


def test_of_very_many_pairs_only_those_with_the_leader_are_meant():
    table = pd.DataFrame({"needed": [40.0, 90.0], "method": "formula"})
    assert trials.summary(table, 9)[0].startswith(
        "Of the pairs with the leader of a problem, 2 pairs are not separated."
    )


def test_several_folders_are_not_judged_at_looks(make, tmp_path, folder):
    other = make(tmp_path / "other", trials=12)
    Folder(other).claim(Folder(other).study().override(looks=(8, 12)))
    known = Findings(Results(folder, other))
    assert known.results.study.looks == ()
    assert known.results.looked == ["other"]
    assert known.results.planned["a (other)"] == 8
    assert any("stopped by declared looks" in each for each in verdict.section(known).cards[2].text)
