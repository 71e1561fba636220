"""What differs between optimizers besides their algorithms: read from plug-ins and study, for any of them."""

import re
from dataclasses import replace

import pytest

from bench import Results, Study
from bench.execution.supervisor import Task, check
from bench.study.budget import Budget
from bench.study.descriptions import Description, noted
from bench.study.tuned import Tuning
from bench.topics.findings import Findings
from bench.topics.matched import conditions
from bench.topics.matched.conditions import conditions_table
from bench.topics.methods import section as methods
from bench.topics.verdict import section as verdict


def study(*optimizers):
    return Study.from_dict({"name": "s", "problems": [{"name": "signature-03"}], "optimizers": list(optimizers)})


def sentences(own, descriptions):
    """Return the sentences where the first optimizer leads."""
    return conditions.sentences(own, descriptions, own.optimizers[0].label)


def said(*optimizers):
    own = study(*optimizers)
    return [each for kind in sentences(own, noted(own, {})) for each in kind]


THESIS = {"name": "cma-es", "agents": 300, "handling": "box", "start": "midpoint"}


def test_the_thesis_s_study_differs_in_handling_and_start():
    own = Study.load("thesis")
    differing, changed = sentences(own, noted(own, {})).limits
    assert "handling and start are box, midpoint for cma-es and repair, random for the 4 others" in differing
    assert "agents" not in differing
    assert "agents = 300 for all; handling = box for cma-es; start = midpoint for cma-es" in changed


def test_a_study_that_was_tuned_points_to_its_tuning():
    own = study({"name": "gwo", "label": "gwo-tuned", "agents": 9})
    record = Tuning("aocc", 1, 1, Budget.read(100), 0, ["sphere"], "", "optuna", ()).sealed()
    edited, trained = replace(record, seed=1), replace(record, train=[own.problems[0].name]).sealed()
    unknown = ((each, "on these problems is not recorded") for each in (None, edited, trained))
    for tuning, words in ((record, "on other problems, is stated below"), *unknown):
        (changed,) = [
            each for each in sentences(replace(own, tuning=tuning), noted(own, {})).limits if "agents = 9" in each
        ]
        assert words in changed


def test_the_equal_study_differs_in_its_populations_alone():
    own = Study.load("thesis-equal")
    differing, _ = sentences(own, noted(own, {})).limits
    assert "agents is 30 for" in differing
    assert not re.search("handling|start", differing)
    labels = [entry.label for entry in own.optimizers]
    for agents in (30, 100, 300):
        alike = [label for label in labels if label.endswith(f" {agents}")]
        assert alike == [f"{name} {agents}" for name in ("cma-es", "alo", "goa", "gwo", "da")]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("optimizers", "expected"),
    [
        (
            [{"name": "gwo"}, {"name": "da"}],
            ("same agents (30), handling (repair) and start (random)", "All options are"),
        ),
        ([{"name": "gwo"}, {"name": "cma-es"}], ("same handling (repair) and start (random)", "All options are")),
        ([{"name": "gwo"}, {"name": "cma-es", "agents": 9}], ("agents is 30 for gwo and 9 for cma-es", "agents = 9")),
        ([{"name": "gwo"}, {"name": "scipy:dual_annealing"}], ("All options are",)),
        (
            [THESIS, {"name": "gone", "agents": 5}],
            ("agents is 300 for cma-es and 5 for gone", "gone are not all known"),
        ),
        ([{"name": "imported:A"}, {"name": "imported:B"}], ("imported:A and imported:B are not all known",)),
    ],
)
def test_each_kind_of_study_has_its_sentences(optimizers, expected):
    found = said(*optimizers)
    assert len(found) == len(expected)
    assert all(part in sentence for part, sentence in zip(expected, found, strict=True)), found


def test_a_plug_in_of_a_stranger_without_such_options_is_described(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def mine(objective, rng, step=0.1):\n    objective(objective.initial(1))\n")
    own = study({"name": f"{path}:mine", "label": "mine", "step": 0.5}, {"name": "gwo"})
    (changed,) = sentences(own, check(Task.of(own)).descriptions).limits
    assert "step = 0.5 for mine" in changed


def test_many_ways_are_counted_and_the_table_has_each():
    own = study(*({"name": "gwo", "label": f"g{agents}", "agents": agents} for agents in range(3, 12)))
    differing, changed = sentences(own, noted(own, {})).limits
    assert "agents is set in 9 ways" in differing
    assert "9 options of 9 of 9 optimizers" in changed
    table = conditions_table(own, noted(own, {})).frame
    assert table.loc["g5"].tolist() == ["5", "repair", "random", "agents = 5 (30)"]


def test_without_any_description_only_the_study_is_known():
    own = study(THESIS, {"name": "gwo"})
    (unknown,), (alike,) = sentences(own, {})
    assert "same known agents (300), handling (box) and start (midpoint)" in alike
    assert unknown.startswith("The options of cma-es and gwo are not all known")
    assert conditions_table(own, {"gwo": Description()}).frame.loc["gwo", "agents"] == "not known"


def test_what_is_usual_or_the_same_limits_no_claim(make, tmp_path, monkeypatch):
    assert not sentences(*both(study({"name": "gwo"}, {"name": "da"}))).limits
    differing = sentences(*both(study({"name": "gwo"}, {"name": "cma-es", "handling": "box"})))
    assert "differ in more than their algorithms" in differing.limits[0]
    assert not differing.others
    findings = Findings(Results(make(tmp_path / "s", trials=2)))
    monkeypatch.setitem(findings.__dict__, "descriptions", {"a": Description({}, {}), "b": Description({}, {})})
    claim, _, limits, _, decided = verdict.section(findings).cards
    assert "All known options are the optimizers’ defaults" in " ".join(decided.text)
    assert "All known options" not in " ".join((*claim.text, *limits.text))
    assert "The options of c are not all known" in " ".join(limits.text)


def both(own):
    """Return a study with the descriptions of its optimizers."""
    return own, noted(own, {})


def test_verdict_and_methods_have_them(make, tmp_path):
    findings = Findings(Results(make(tmp_path / "s", trials=2)))
    assert "The options of a, b and c are not all known" in " ".join(verdict.section(findings).cards[2].text)
    table = next(each for each in methods.section(findings).items if each.name == "conditions")
    assert set(table.frame.to_numpy().ravel()) == {"not known"}


@pytest.mark.parametrize(("leader", "found"), [("gwo[agents=9]", False), ("da", True)])
def test_what_a_sweep_varies_is_its_question_and_no_condition_of_its_best(leader, found):
    own = study({"name": "gwo", "options": {"agents": [5, 9]}}, {"name": "da", "agents": 9})
    text = conditions.differing(own, noted(own, {}), leader)
    assert text == ("agents is 5 for gwo[agents=5] and 9 for the 2 others" if found else "")


def test_a_default_population_is_part_of_the_algorithm_in_every_sentence():
    own = study({"name": "gwo"}, {"name": "cma-es"})
    assert conditions.differing(own, noted(own, {}), "cma-es") == ""
    assert not conditions.sentences(own, noted(own, {}), "cma-es").limits
