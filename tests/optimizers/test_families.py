"""What the families of other libraries share: a library is imported when needed, and missed in one sentence."""

import sys
import tomllib

import pytest

from bench import BenchError, Study, load_optimizer

FAMILIES = {"mealpy": "OriginalGWO", "minion": "LSHADE", "nevergrad": "DE", "optuna": "TPESampler", "pymoo": "DE"}
MODULES = {"minion": "minionpy"}  # where it is not the family's name
each_family = pytest.mark.parametrize(("family", "member"), FAMILIES.items())


@each_family
def test_a_missing_library_names_its_extra(family, member, monkeypatch):
    module = MODULES.get(family, family)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BenchError) as caught:
        load_optimizer(f"{family}:{member}")
    assert str(caught.value) == (
        f"the {family} optimizers need {module}; install it with: pip install 'backlash-bench[{family}]'"
    )


@each_family
def test_an_unknown_member_is_refused_with_the_nearest_one(family, member):
    pytest.importorskip(MODULES.get(family, family), reason=f"the extra {family!r} is not installed")
    with pytest.raises(BenchError, match=f"{family} has no optimizer '{member}x'; did you mean"):
        load_optimizer(f"{family}:{member}x")


def test_a_family_is_no_optimizer_itself():
    with pytest.raises(BenchError, match="'scipy' is no Optimizer subclass, nor a family's member: name one as"):
        load_optimizer("scipy")


def study(**optimizers):
    return Study.from_dict({"name": "s", "problems": [{"name": "signature-12"}], "optimizers": [optimizers]})


def test_a_pattern_stands_for_all_members_that_fit():
    labels = [entry.label for entry in study(name="scipy:d*").optimizers]
    assert labels == ["scipy:differential_evolution", "scipy:direct", "scipy:dual_annealing"]
    frozen = Study.from_dict(tomllib.loads(study(name="scipy:d*", handling="box").to_toml()))
    assert [entry.options for entry in frozen.optimizers] == [{"handling": "box"}] * 3
