"""What the problems of every suite owe: values by the point alone, features, sentences for names that there are not."""

import sys
from importlib.util import find_spec

import pytest

from bench import BenchError, load_problem
from problems.classical.family import FUNCTIONS
from tests.problems.suites import assert_pure_and_reloadable

NEEDS = {"bbob": "cocoex", "cec20": "minionpy", "gnbg": "iohgnbg", "sbox": "ioh", "ma-bbob": "ioh", "star": "ioh"}
EXTRAS = {"cocoex": "suites", "minionpy": "suites", "iohgnbg": "ioh", "ioh": "ioh"}


def needed(name):
    """Return the package that a problem needs; None for those written here."""
    return next((module for start, module in NEEDS.items() if name.startswith(start)), None)


def loaded(name, **options):
    if needed(name) and not find_spec(needed(name)):
        pytest.skip(f"{needed(name)} is not installed")
    return load_problem(name, **options)


@pytest.mark.parametrize(
    "name",
    ["bbob-f03-d10-i2", "bbob-boxed-f07-d5-i1", "bbob-largescale-f21-d40-i1", "bbob-mixint-f08-d10-i2",
     "bbob-constrained-f14-d5-i2", "gnbg-f20-d30", "sbox-cost-f21-d3-i2", "ma-bbob-f0003-d5",
     "star-discrepancy-sobol-50-d5-i1", *(f"classical-{function}-d10-i4" for function in FUNCTIONS)],
)  # fmt: skip
def test_values_depend_on_the_point_alone(name):
    assert_pure_and_reloadable(loaded(name))


@pytest.mark.parametrize(
    ("name", "features"),
    [
        ("bbob-f08-d10-i3", {"function": "f08", "instance": 3, "group": "low or moderate conditioning"}),
        ("bbob-noisy-f113-d3-i4", {"function": "f113", "instance": 4, "group": "severe noise"}),
        ("bbob-constrained-f14-d5-i2",
         {"function": "f14", "instance": 2, "group": "rotated ellipsoid", "constraints": 3}),
        ("sbox-cost-f08-d5-i3", {"function": "f08", "instance": 3, "group": "low or moderate conditioning"}),
        ("ma-bbob-f0003-d5", {"function": "f0003", "group": "affine combination"}),
        ("star-discrepancy-sobol-50-d5-i1", {"function": "sobol-50", "instance": 1, "group": "sobol points"}),
        ("classical-rastrigin-d30-i2", {"function": "rastrigin", "instance": 2, "group": "multimodal, non-separable"}),
        ("engineering-spring", {"function": "spring", "group": "constrained"}),
        ("engineering-gear-train", {"function": "gear-train", "group": "constrained, mixed-integer"}),
    ],
)  # fmt: skip
def test_a_problem_says_its_suite_function_instance_and_group(name, features):
    suite = name.partition(f"-{features['function']}")[0]
    assert loaded(name).features == {"suite": suite} | features


@pytest.mark.parametrize(
    ("name", "options", "sentence"),
    [
        ("bbob-f25-d5-i1", {}, "bbob has no function 'f25'; it has f01 to f24"),
        ("bbob-f08-d7-i1", {}, "f08 of bbob has no dimension 7; it has 2, 3, 5, 10, 20, 40"),
        ("bbob-f08-d5-i1", {"rotate": True}, "'bbob-f08-d5-i1' has no option 'rotate'; there are none"),
        ("bbob-f08-d5-i0", {}, "instance of 'bbob-f08-d5-i0' must be a whole number from 1 to 200000, not 0"),
        ("bbob-f08-d5", {}, "the problems of bbob have names such as 'bbob-f01-d2-i1'"),
        ("bbob-f08-d05-i1", {}, "unknown problem 'bbob-f08-d05-i1'"),
        ("cec2017-f02-d10", {}, "cec2017 has no function 'f02'; it has f01 to f30 without f02"),
        ("cec2022-f05-d30", {}, "f05 of cec2022 has no dimension 30; it has 10, 20"),
        ("cec2013-f01-d10", {}, "unknown problem 'cec2013-f01-d10'; did you mean 'cec201"),
        ("classical-rastrign-d30-i2", {}, "classical has no function 'rastrign'; did you mean 'rastrigin'?"),
        ("classical-rastrigin-d5-i1", {"rotate": "no"}, "rotate must be true or false, not 'no'"),
        ("engineering-welded-bem", {}, "'engineering-welded-bem'; did you mean 'engineering-welded-beam'"),
        ("engineering-spring", {"penalty": 1}, "has no option 'penalty'; there are none"),
    ],
)
def test_one_sentence_names_what_there_is(name, options, sentence):
    with pytest.raises(BenchError) as caught:
        load_problem(name, **options)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    "name", ["bbob-f08-d5-i1", "cec2022-f05-d10", "gnbg-f01-d30", "sbox-cost-f01-d2-i1", "ma-bbob-f0001-d2",
             "star-discrepancy-sobol-10-d2-i1"]
)  # fmt: skip
def test_without_the_extra_one_sentence_says_what_to_install(name, monkeypatch):
    monkeypatch.setitem(sys.modules, needed(name), None)
    wanted = rf"'{name}' needs {needed(name)}; install it with: .*\[{EXTRAS[needed(name)]}\]"
    with pytest.raises(BenchError, match=wanted):
        load_problem(name)
