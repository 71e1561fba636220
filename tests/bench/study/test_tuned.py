"""The record of a tuning in a study: it survives its TOML, changes no identity, and keeps training problems away."""

import copy
import tomllib

import pytest

from bench import BenchError, Study

RECORD = {
    "objective": "aocc", "trials": 3, "runs": 2, "budget": "10 * d", "seed": 4, "train": ["sphere-3"], "left_out": "",
    "method": "optuna 1", "optimizers": [
        {
            "name": "scatter", "default": "scatter", "tuned": "scatter-tuned", "failed": 0, "evaluations": 50,
            "seconds": 0.5, "parameters": {"agents": {"low": 5, "high": 50, "log": True}},
            "values": {"agents": [10, 7, 5]}, "scores": [0.5, 0.4, 0.6], "problems": [1, 1, 1], "importance": {},
        },
    ],
}  # fmt: skip
STUDY = {"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}]}


def study(record=None, **changes):
    return Study.from_dict(STUDY | {"tuning": RECORD if record is None else record} | changes)


def test_a_record_survives_the_toml_and_is_no_part_of_the_identity(tmp_path):
    given = study()
    (tmp_path / "s.toml").write_text(given.to_toml())
    assert Study.load(tmp_path / "s.toml") == given
    assert given.identity() == Study.from_dict(STUDY).identity()
    assert given.tuning.optimizers[0].best == 0.4
    assert "tuning" not in Study.from_dict(STUDY).to_toml()


def test_an_edited_record_is_doubted_and_one_that_was_only_written_and_read_is_not(tmp_path):
    tuning = study(RECORD | {"budget": {"2": 60, "10": 300}}).tuning
    assert "has no hash: an earlier version wrote it" in tuning.doubt
    sealed = study(tuning.sealed())
    (tmp_path / "s.toml").write_text(sealed.to_toml())
    read = Study.load(tmp_path / "s.toml")
    assert read.tuning.doubt == ""
    assert read.tuning.is_apart(["sphere-2"])
    assert not read.tuning.is_apart(["sphere-2", "sphere-3"])
    text = sealed.to_toml()
    for old, new in (('"sphere-3"', '"sphere-4"'), ("seed = 4", "seed = 5"), ("0.4", "0.3"), ("10 = 300", "10 = 3")):
        assert old in text
        edited = Study.from_dict(tomllib.loads(text.replace(old, new)))
        assert "does not fit its hash: it was edited" in edited.tuning.doubt
        assert not edited.tuning.is_apart(["sphere-2"])
        again = Study.from_dict(tomllib.loads(edited.to_toml()))  # as a run freezes it
        assert again.tuning.doubt


def test_stopped_configurations_are_not_the_best():
    record = copy.deepcopy(RECORD)
    record["optimizers"][0] |= {"problems": [3, 1, 3]}
    (own,) = study(record).tuning.optimizers
    assert own.whole == [True, False, True]
    assert own.best == 0.5


def test_a_problem_that_was_trained_on_is_refused_from_the_file_and_from_the_command():
    with pytest.raises(BenchError, match="study given: the optimizers were tuned on 'sphere-3', so it cannot be a"):
        study(problems=[{"names": ["sphere-2", "sphere-3"]}])
    with pytest.raises(BenchError, match="study 's': the optimizers were tuned on 'sphere-3'"):
        study().beside(problems=["sphere-3"])
    assert len(study().beside(optimizers=["early"]).optimizers) == 2


@pytest.mark.parametrize(
    "change",
    [
        {"trains": []},
        {"seed": "x"},
        {"train": [3]},
        {"train": "sphere-3"},
        {"optimizers": [3]},
        *(
            {"optimizers": [RECORD["optimizers"][0] | own]}
            for own in (
                {"parameters": {"agents": 3}},
                {"parameters": {"handling": {"choices": ["box"]}}},
                {"scores": [0.5, 1.0, float("nan")]},
                {"scores": [1.0]},
                {"failed": None},
            )
        ),
    ],
)
def test_a_record_that_no_tuning_wrote_costs_one_sentence(change):
    with pytest.raises(BenchError, match="study given: 'tuning' must be a table as 'bench tune' writes it; restore it"):
        study(RECORD | change)


def test_what_is_no_record_costs_the_same_sentence():
    for value in (3, [], {}, "aocc"):
        with pytest.raises(BenchError, match="'tuning' must be a table as 'bench tune' writes it"):
            study(value)
