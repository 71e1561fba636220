"""The table of rules: sound optimizers keep all of them, and every rule stands after those that it needs."""

import re
from pathlib import Path

import pytest

from bench.check.conformance.rules import APART, PROBLEM_RULES, RULES, SEARCH, find_rule
from tests.bench.check import faulty
from tests.bench.check.conformance.examine import ALL, failures, verdicts


def test_every_rule_has_a_name_of_its_own_and_stands_after_those_that_it_needs():
    names = [rule.name for rule in RULES]
    assert len(set(names)) == len(names)
    for number, rule in enumerate(RULES):
        assert set(rule.needs) <= set(names[:number])
        assert find_rule(rule.name) is rule
        assert rule.remedy


@pytest.mark.parametrize(
    ("title", "rules"),
    [("contract of an optimizer", (*RULES, APART)), ("contract of a problem", (*PROBLEM_RULES, SEARCH))],
)
def test_the_page_of_warnings_says_what_to_do_about_every_rule_and_no_other(title, rules):
    page = Path(__file__).resolve().parents[4] / "docs" / "reference" / "warnings.md"
    rows = page.read_text(encoding="utf-8").partition(f"### {title}\n")[2].partition("\n### ")[0]
    named = [name for row in re.findall(r"^\| ([a-z ,]+) \|", rows, re.MULTILINE) for name in row.split(", ")]
    assert sorted(named) == sorted(["rule", *(rule.name for rule in rules)])


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["random-search", "gwo", "alo", "goa", "da", "cma-es"])
@pytest.mark.slow
def test_built_ins_conform(name):
    found = verdicts(name, RULES)
    assert not failures(found)
    assert found.keys() == ALL


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("optimizer", "check", "finding"),
    [
        (faulty.Sound, "repetition", "a seed repeats its run, other seeds give others"),
        (faulty.Deterministic, "repetition", "deterministic: "),
        (faulty.Pattern, "repetition", "other seeds give others"),
        (faulty.Tired, "budget", "stopped early and declared: tired"),
        (faulty.Careful, "budget", "kept budgets of 1, 2, 6, 1000 to the evaluation"),
        (faulty.Outdated, "silence", "nothing printed; warned: UserWarning: deprecated"),
    ],
)
@pytest.mark.filterwarnings("ignore:deprecated")
def test_a_sound_optimizer_passes_whatever_its_ways(optimizer, check, finding):
    found = verdicts(optimizer)
    assert not failures(found)
    assert finding in found[check].finding
