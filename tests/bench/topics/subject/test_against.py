"""The subject of a study: whom it beats, on the first screen, in its table, in the answer and the methods."""

import json
from dataclasses import replace

import pandas as pd
import pytest

from bench import BenchError, Results, Study
from bench.analysis import Levels
from bench.topics import write_report
from bench.topics.conditions.differing import Differing
from bench.topics.findings import Findings
from bench.topics.methods import section as methods
from bench.topics.subject import section as subject
from bench.topics.subject.against import Against, Rival, against, first_screen
from bench.topics.trials.power import error_text
from bench.topics.verdict import section as verdict

PARTS = pd.DataFrame(columns=["kind", "part", "rival", "outcome"])


def rival(label, outcome, chance=0.7, **more):
    known = {"low": chance - 0.03, "high": chance + 0.03, "p": 0.001, "better": 3, "worse": 1}
    return Rival(label=label, outcome=outcome, chance=chance, **(known | {"ratio": 2.0, "both": 4} | more))


def known(*rivals, **more):
    facts = {
        "subject": "rDE", "rivals": rivals, "parts": PARTS, "levels": Levels(0.01, 0.035, 0.005), "enough": 0,
        "parts_level": 0.005, "pairs": len(rivals),
        "declared": True, "problems": 24, "trials": "15 trials", "budget": "1,000 d evaluations",
        "target": "precision 1e-8", "unlike": Differing(), "selected": False,
    }  # fmt: skip
    return Against(**(facts | more))


FOUR = (
    rival("BIPOP-CMA-ES", "worse", 0.3), rival("L-SHADE", "open", 0.52), rival("JADE", "better"), rival("GWO", "better")
)  # fmt: skip


def lines(facts):
    return {line.label: line.text for line in first_screen(facts).lines}


@pytest.mark.parametrize(
    ("outcomes", "said"),
    [
        (["better"] * 3, "rDE beats all 3 rivals on"),
        (["better"], "rDE beats r0 on"),
        (["worse"] * 3, "rDE loses to all 3 rivals on"),
        (["open"] * 5, "rDE is open against all 5 rivals on"),
        (["worse", "open", "open", "open"], "rDE loses to r0 and is open against 3 rivals on"),
        (["open", "better"], "rDE beats 1 of 2 rivals and is open against r0 on"),
    ],
)
def test_headlines_of_every_outcome(outcomes, said):
    facts = known(*(rival(f"r{place}", outcome) for place, outcome in enumerate(outcomes)))
    assert first_screen(facts).headline.startswith(said)


def test_the_lines_say_where_by_how_much_how_sure_and_at_what_cost():
    parts = pd.DataFrame(
        [("dimension", "2", "BIPOP-CMA-ES", "better"), ("budget", "1%", "GWO", "worse"),
         ("budget", "3%", "GWO", "worse"), ("class", "separable", "JADE", "better")],
        columns=PARTS.columns,
    )  # fmt: skip
    assert lines(known(*FOUR, parts=parts)) == {
        "where": "worse than GWO at 1% and 3% of the budget; better than BIPOP-CMA-ES in dimension 2",
        "by how much": "a run ends lower than one of BIPOP-CMA-ES in 30% [27, 33] of pairs, JADE in 70% [67, 73]",
        "how sure": "at most 5% of such pages claim too much; tested against its rivals alone",
        "at what cost": "to precision 1e-8, BIPOP-CMA-ES needs 2 times as many evaluations (median of 4 problems), "
        "JADE 2 times (4)",
    }


@pytest.mark.parametrize(
    "more", [{}, {"unlike": Differing("start differs", "start differs")}, {"declared": False}, {"selected": True}]
)
@pytest.mark.parametrize("levels", [Levels(0.01, 0.035, 0.005), Levels(0.05, 0.0), Levels(0.0, 0.0)])
@pytest.mark.parametrize("rivals", [FOUR, FOUR[:1], tuple(rival(f"r{i}", "open", both=0) for i in range(12))])
def test_the_first_screen_is_read_at_a_glance(more, levels, rivals):
    said = first_screen(known(*rivals, levels=levels, **more))
    assert len(said.headline.split()) <= 25
    assert len(said.lines) <= 4 + ("unlike" in more)
    assert max(len(line.text.split()) for line in said.lines) <= 20
    assert said.headline.endswith(", under unlike conditions.") == ("unlike" in more)


def test_the_abstract_is_one_sentence_with_intervals():
    (abstract, *_) = first_screen(known(*FOUR)).details
    assert abstract.startswith(
        "On 24 problems with 15 trials of 1,000 d evaluations each, rDE ended lower than JADE (0.70 [0.67, 0.73]) and "
        "GWO (0.70 [0.67, 0.73]), ended higher than BIPOP-CMA-ES (0.30 [0.27, 0.33]) and did not differ significantly "
        "from L-SHADE (0.52 [0.49, 0.55]) ("
    )
    assert abstract.endswith("adjusted over 4 pairs, level 0.035).")


def test_untested_pairs_are_no_claim():
    said = first_screen(known(*FOUR, levels=Levels(0.0, 0.0), trials="1 trial"))
    assert said.headline.startswith("rDE is untested against its 4 rivals: 1 trial a cell is too few on these")


# a real folder: a finds about 5, b about 6 and c about 7


@pytest.fixture(scope="module")
def folder(make, tmp_path_factory):
    return make(tmp_path_factory.mktemp("subject") / "s", trials=12)


def findings(folder, label="b", first="b", **changes):
    results = Results(folder)
    results.study = replace(results.study, subject=label, **changes)
    results.environments[:] = [{"started": "2026-01-02", "subject": "b"}, {"started": "2026-01-01", "subject": first}]
    return Findings(results)


def test_a_subject_that_the_first_run_named_is_tested_alone(folder):
    found = findings(folder)
    assert found.declared
    assert found.final.tests == 4  # 2 rivals on 2 problems
    assert found.final.pairs["p_holm"].notna().sum() == 4
    assert [each.outcome for each in against(found).rivals] == ["worse", "better"]
    assert "b against each other one" in error_text(found)[0]
    assert "We compare b with each other optimizer by A12" in " ".join(methods.section(found).text)


@pytest.mark.parametrize("first", ["", "a", None])
def test_a_subject_that_the_first_run_did_not_name_is_stated_and_every_pair_counts(folder, first):
    found = findings(folder, first=first)
    assert not found.declared
    assert found.final.tests == 6
    cards = verdict.section(found).cards
    assert "named late, so all 3 pairs count" in str(cards[0].lines)
    assert "No run named b as the subject before the first trial" in cards[1].text[1]
    assert "No run named b before the first trial. We compare every pair" in " ".join(methods.section(found).text)


def test_the_table_has_a_row_for_each_rival(folder):
    found = subject.section(findings(folder))
    table = found.items[0]
    assert table.frame["outcome"].to_dict() == {"a": "worse", "c": "better"}
    assert table.frame["better / worse / open"].to_dict() == {"a": "0 / 2 / 0", "c": "2 / 0 / 0"}
    assert table.frame.index.name == "b against"
    assert set(table.data) >= {"label", "outcome", "chance", "low", "high", "p", "ratio"}


def test_tests_over_all_problems_that_all_reject_pass_their_level_on_to_parts(make, folder, tmp_path):
    known = against(findings(folder))
    assert known.parts_level == pytest.approx(known.levels.course + known.levels.across)
    alike = against(findings(make(tmp_path / "s", changes={"c": {"fun": 6.0}, "b": {"fun": 6.0}})))
    assert alike.parts_level == alike.levels.course
    rule = verdict.section(findings(folder)).cards[4].text[0]
    assert f"together, by Holm’s method, or at {known.parts_level:g} where every test over all problems rejects" in rule


def test_without_a_subject_there_is_no_section(folder):
    assert subject.section(findings(folder, "")) is None
    assert subject.section(findings(folder, "gone")) is None


def test_the_report_begins_with_the_subject(folder, tmp_path):
    page = write_report(folder, output=tmp_path / "out", subject="c", n_jobs=1)
    assert json.loads((tmp_path / "out" / "answer.json").read_text())["sentence"].startswith("c loses to a and b on")
    assert "against-rivals" in page.read_text()


def test_small_and_odd_studies_have_a_first_screen(make, tmp_path):
    for name, options in {"one": {"trials": 1}, "two": {"trials": 2, "fail": [("p", "b"), ("q", "b")]}}.items():
        found = findings(make(tmp_path / name, **options))
        assert verdict.section(found).cards[0].text[0].startswith("b ")
        assert subject.section(found).items
    alone = findings(make(tmp_path / "alone", optimizers=("b",)))
    assert subject.section(alone) is None


def test_a_study_names_its_subject_among_its_optimizers():
    base = {
        "name": "s", "problems": [{"name": "signature-01"}], "optimizers": [{"name": "gwo"}, {"name": "alo"}],
        "subject": "alo",
    }  # fmt: skip
    study = Study.load(base)
    assert study.identity() == Study.load(base | {"subject": ""}).identity()
    assert 'subject = "alo"' in study.to_toml()
    with pytest.raises(BenchError, match="has no optimizer 'al'; did you mean 'alo'"):
        Study.load(base | {"subject": "al"})
    with pytest.raises(BenchError, match="'subject' must be a text"):
        Study.load(base | {"subject": 3})
