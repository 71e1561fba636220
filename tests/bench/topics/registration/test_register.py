"""The text of a registration states the tests of the study's design, and reads back as what was registered."""

import re

import pytest

from bench import BenchError, Study
from bench.analysis.error_rates import levels
from bench.storage.folder import REGISTRATION
from bench.study import Fingerprints
from bench.topics.registration.register import Registered, read, register, text_of
from bench.topics.trials.design import foreseen

STUDY = {
    "name": "s", "trials": 15, "budget": 100, "problems": [{"name": "p"}, {"name": "q", "label": 'the "q" ```toml'}],
    "optimizers": [{"name": "a", "handling": "box"}, {"name": "b"}, {"name": "c"}],
}  # fmt: skip
FOUND = Fingerprints({"p": "12", 'the "q" ```toml': ""}, {"a": {"a.py": "ab"}, "b": {}, "c": {}}, {"p": 2})


def text(**changes):
    return text_of(Registered("2026-01-02T03:04:05+00:00", Study.from_dict(STUDY | changes), FOUND))


@pytest.fixture
def path(tmp_path):
    return register(Study.from_dict(STUDY), FOUND, tmp_path / "new" / "s")


def test_it_reads_back_as_it_was_registered(path):
    registered = read(path)
    assert path.name == REGISTRATION
    assert registered[1:] == (Study.from_dict(STUDY), FOUND)


def test_it_states_the_levels_of_the_design_and_their_power():
    level = levels([15, 15], 3, 6)
    assert f"Holm’s method over 6 tests at the level {level.problems:g}" in text()
    assert f"Holm’s method over 3 pairs at the level {level.across:g}" in text()
    for line in foreseen(Study.from_dict(STUDY)):
        assert f"- {line}\n" in text()


def test_a_subject_is_tested_against_its_rivals_alone():
    assert "for a against each other optimizer. Holm’s method over 4 tests" in text(subject="a")
    assert "a is called better than a rival, or worse, if the test over all problems shows it" in text(subject="a")


def test_looks_are_its_stopping_rule_and_test_all_pairs():
    looked = text(looks={"trials": [6, 15]}, subject="a")
    assert "The pairs of a problem are tested at 6, 15 trials" in looked
    assert "Every optimizer gets all trials" in text()
    assert "every pair of optimizers. Holm’s method over 6 tests at the level 0.05" in looked
    assert "- Over all problems" not in looked


def test_tests_that_can_show_nothing_are_no_claims():
    assert text(trials=2).count("no such test can be significant, and none is a claim") == 2
    assert "nothing is tested" in text(optimizers=[{"name": "a"}])


@pytest.mark.parametrize("edit", [("Seed: 0", "Seed: 1"), ("trials = 15", "trials = 16"), ("SHA-256", "SHA")])
def test_an_edit_is_noticed(path, edit):
    before = path.read_text(encoding="utf-8")
    assert edit[0] in before
    path.write_text(before.replace(*edit), encoding="utf-8")
    with pytest.raises(BenchError, match=re.escape(f"{path} was edited after it was written")):
        read(path)


def test_ends_of_lines_are_no_edit(path):
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert read(path).study.trials == 15


def test_it_is_never_replaced(path):
    with pytest.raises(BenchError, match="a registration is never replaced"):
        register(Study.from_dict(STUDY), FOUND, path.parent)


def test_a_folder_with_trials_takes_none(make, tmp_path):
    with pytest.raises(BenchError, match="holds trials already"):
        register(Study.from_dict(STUDY), FOUND, make(tmp_path / "made"))


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BenchError, match="cannot be written"):
        register(Study.from_dict(STUDY), FOUND, tmp_path / "file" / "s")
