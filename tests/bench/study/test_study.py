"""Studies: reading, checking, planning, and what makes two of them the same."""

import pytest

from bench import BenchError, Study
from bench.contract.seeds import trial_seed
from bench.study.descriptions import repairing

MINIMAL = {"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": [{"name": "scatter"}]}


def study(**changes):
    return Study.from_dict(MINIMAL | changes)


def test_a_study_survives_its_toml(small_study, tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(small_study.to_toml())
    assert Study.load(path) == small_study


def test_the_thesis_study_is_that_of_section_7_2():
    thesis = Study.load("thesis")
    assert [entry.name for entry in thesis.problems] == [f"signature-{k:02d}" for k in range(3, 21)]
    assert (thesis.trials, thesis.budget) == (30, 300 * 200)
    assert {entry.name for entry in thesis.optimizers} == {"cma-es", "alo", "goa", "gwo", "da"}
    for entry in thesis.optimizers:
        optimizer = thesis.optimizer(entry.label)
        assert optimizer.agents == 300
        assert optimizer.handling == ("box" if entry.name == "cma-es" else "repair")


def test_seeds_depend_on_nothing_but_what_a_trial_is():
    a = study(trials=2, problems=[{"names": ["sphere-2", "sphere-3"]}])
    b = study(
        trials=5, problems=[{"names": ["sphere-3", "sphere-2"]}], optimizers=[{"name": "early"}, {"name": "scatter"}]
    )
    seeds = {trial.key: trial.seed for trial in b.plan()}
    for trial in a.plan():
        assert seeds[trial.key] == trial.seed
    assert len(set(seeds.values())) == len(seeds)


def test_a_seed_is_pinned():
    assert trial_seed(2024, "signature-12", "gwo", 0) == 4642658214545525248


def test_identity_is_what_decides_a_result():
    same = [study(), study(trials=9), study(title="other words"), study(targets="quantiles"), study(targets=[0.1])]
    same += [study(parallel=8), study(evaluation_timeout=None, time=None)]
    assert len({each.identity() for each in same}) == 1
    other = [study(budget=77), study(seed=1), study(optimizers=[{"name": "scatter", "agents": 5}])]
    other += [study(on_error="worst"), study(evaluation_timeout=5), study(time="10 min"), study(time=601)]
    assert len({each.identity() for each in [study(), study(on_error="fail"), *other]}) == 8


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"trials": "3"}, "'trials' must be a whole number"),
        ({"seed": -1}, "'seed' must be a whole number from 0 to 9223372036854775807, not -1"),
        ({"title": "a" * 1001}, "the title has 1,001 characters, more than 1,000"),
        ({"optimizers": [{"name": "gwo", "label": "a" * 201}]}, "of the optimizers has 201 characters, more than 200"),
        ({"name": ""}, "has no name"),
        ({"time": "soon"}, "'time' must be a number of seconds above 0, or a text such as '10 min', not 'soon'"),
        ({"parallel": 0}, "'parallel' must be a whole number from 1 to 1000, not 0"),
        ({"targets": [1, -1]}, "percentages of the optimum such as ['5%', '1%'], not [1, -1]"),
        ({"problems": []}, "needs at least one [[problems]] table"),
        ({"optimizers": [{"agents": 3}]}, "needs a name"),
        ({"optimizers": [{"name": "scatter"}, {"name": "scatter", "agents": 5}]}, "'scatter' occurs twice"),
    ],
)
def test_a_study_that_makes_no_sense_is_named(changes, said):
    with pytest.raises(BenchError) as caught:
        study(**changes)
    assert said in str(caught.value)


def test_check_finds_a_budget_that_no_generation_fits():
    with pytest.raises(BenchError, match="a budget of 9 evaluations is below one generation of 'scatter', which takes"):
        study(budget=9).check_optimizers(["scatter"], {"sphere-2": 2})


def test_an_unknown_key_names_the_nearest():
    with pytest.raises(BenchError, match=r"unknown key 'trails'; did you mean 'trials'\?"):
        study(trails=1)


NAMED = {
    "bbob": "a3f124d49cdd0b4c", "bbob-quick": "37e83ee438deb5dc", "cec2022": "f360fb28900e84ea",
    "engineering": "61cd7777f1b8b10f", "noise": "7042e9f2b646c6e5", "published": "05692ba560412866",
    "quick": "45ec5a24133cee76", "thesis": "798b152c548e4da2", "thesis-equal": "2ec428c91048724e",
    "thesis-plus": "e0eef6ffb144e1d1", "wrist": "4bb732c0e24ed1d3",
}  # fmt: skip


@pytest.mark.parametrize(("name", "identity"), NAMED.items())
def test_the_identity_of_a_named_study_stays_as_it_was(name, identity):
    assert Study.load(name).identity() == identity


def test_each_label_has_the_files_that_its_entry_names_and_repairs_unless_its_handling_is_the_box():
    optimizers = [{"name": "gwo", "files": ["a.csv"]}, {"name": "gwo", "label": "box", "handling": "box"}]
    named = Study.from_dict({"name": "s", "problems": [{"name": "sphere-2"}], "optimizers": optimizers})
    assert (named.files("gwo"), named.files("box")) == (("a.csv",), ())
    assert repairing(named) == {"gwo": True, "box": False}
