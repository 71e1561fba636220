"""What the families of other libraries share: a library is imported when needed, and missed in one sentence."""

import sys
import tomllib

import pytest

from bench import BenchError, Study, load_optimizer

FAMILIES = {"mealpy": "OriginalGWO", "minion": "LSHADE", "nevergrad": "DE", "optuna": "TPESampler", "pymoo": "DE"}
MODULES = {"minion": "minionpy"}  # where it is not the family's name
NAMED = FAMILIES.items()


@pytest.mark.parametrize(("family", "member"), NAMED)
def test_a_missing_library_names_its_extra(family, member, monkeypatch):
    module = MODULES.get(family, family)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BenchError) as caught:
        load_optimizer(f"{family}:{member}")
    assert str(caught.value) == (
        f"the {family} optimizers need {module}; install it with: pip install 'backlash-bench[{family}]'"
    )


REFUSED = [
    *((f"{family}:{member}x", {}, f"{family} has no optimizer '{member}x'; did you mean") for family, member in NAMED),
    ("scipy", {}, "'scipy' is no Optimizer subclass, nor a family's member: name one as"),
    ("scipy:differential_evolution", {"agents": 4}, "'agents' of DifferentialEvolution must be at least 5"),
    ("scipy:dual_annealing", {"visit": 3.0}, "from 1.001 to 2.999"),
    ("mealpy:OriginalABC", {"n_limits": 5000}, "'n_limits' of OriginalABC must be from 1 to 1000, not 5000"),
    ("mealpy:BaseGA", {"pc": 0.0}, "mealpy refuses these parameters of BaseGA: 'pc' is a float"),
    ("minion:L_BFGS", {}, "minion's L_BFGS is left out: it searches without bounds"),
    ("nevergrad:DE", {"initialization": "nowhere"}, "nevergrad refuses these parameters of DE: "),
    ("nevergrad:SQP", {"workers": 2}, "nevergrad's SQP takes one point after the other: its workers must be 1"),
    ("nevergrad:SMAC3", {}, "nevergrad's SMAC3 is left out: it needs a package that nevergrad does not install"),
    ("nevergrad:NGOpt", {}, "left out: in some dimensions or for some budgets it uses an optimizer that"),
    ("pymoo:DE", {"CR": 1.5}, "'CR' of DE must be from 0 to 1, not 1.5"),
    ("pymoo:ES", {"n_offsprings": 20, "agents": 15}, "pymoo refuses these parameters of ES: The number of offsprings"),
    ("pymoo:BGA", {}, "pymoo's BGA is left out: it searches binary strings"),
]


@pytest.mark.parametrize(("name", "options", "sentence"), REFUSED)
def test_what_does_not_fit_is_refused_in_one_sentence(name, options, sentence):
    family = name.partition(":")[0]
    pytest.importorskip(MODULES.get(family, family), reason=f"the extra {family!r} is not installed")
    with pytest.raises(BenchError) as refused:
        load_optimizer(name, **options)
    assert sentence in str(refused.value)


def study(**optimizers):
    return Study.from_dict({"name": "s", "problems": [{"name": "signature-12"}], "optimizers": [optimizers]})


def test_a_pattern_stands_for_all_members_that_fit():
    labels = [entry.label for entry in study(name="scipy:d*").optimizers]
    assert labels == ["scipy:differential_evolution", "scipy:direct", "scipy:dual_annealing"]
    frozen = Study.from_dict(tomllib.loads(study(name="scipy:d*", handling="box").to_toml()))
    assert [entry.options for entry in frozen.optimizers] == [{"handling": "box"}] * 3
