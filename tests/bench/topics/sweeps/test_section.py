"""The section on sweeps; optimizers find about 5, 6, 7 and 8 in the order of the study."""

from itertools import product

import pytest

from bench import Results
from bench.topics.findings import Findings
from bench.topics.sweeps import section as components

OPTIONS = {f"o[n={n},h={h}]": {"n": n, "h": h} for n, h in product((1, 2), ("x", "y"))}
SEVEN = ("p", "q", "r", "s", "t", "u", "v")


def section(folder):
    return components.section(Findings(Results(folder)))


def test_a_study_without_a_sweep_has_no_section(make, tmp_path):
    assert section(make(tmp_path / "s")) is None


def test_shares_best_values_and_tests_are_stated(make, tmp_path):
    found = section(make(tmp_path / "s", SEVEN, tuple(OPTIONS), options=OPTIONS))
    parameters, effects, shares, levels, each = found.items
    assert levels.frame["best on problems"].tolist() == [7, 0, 7, 0]
    assert parameters.frame["across problems (p)"].tolist() == ["0.031"] * 2  # 2 / 2^7, twice
    assert parameters.frame["matters (p)"].tolist() == ["< 0.001"] * 2
    assert parameters.frame["shown to be worse"].tolist() == ["2", "y"]
    assert "n (p < 0.001) and h (p < 0.001) matter on these 7 problems" in found.text[2]
    assert shares.data["share"].sum() == pytest.approx(1, abs=0.01)  # estimates below 0 are shown as 0
    assert each.frame.shape == (7, 4)
    assert set(effects.data["factor"]) == {"n", "h"}


def test_one_problem_one_trial_and_failures_support_no_claim(make, tmp_path):
    one = " ".join(section(make(tmp_path / "a", ("p",), tuple(OPTIONS), options=OPTIONS)).text)
    assert "this describes one problem only" in one
    few = " ".join(section(make(tmp_path / "b", ("p", "q"), tuple(OPTIONS), 1, options=OPTIONS)).text)
    assert "Shares of the variance are not known: a combination has a single trial" in few
    assert "2 problems are too few to test it across problems" in few
    assert "no effect is shown on these 2 problems" in few, few
    lost = section(make(tmp_path / "c", SEVEN, tuple(OPTIONS), options=OPTIONS, fail=list(product(SEVEN, OPTIONS))))
    assert "n: no value stands out, as the mean chance of each is 0.50" in " ".join(lost.text)


def test_a_sweep_that_lacks_a_combination_is_not_taken_apart(make, tmp_path):
    found = section(make(tmp_path / "s", SEVEN, tuple(OPTIONS)[:3], options=OPTIONS))
    assert "The study lacks 1 combination of the parameters of o, such as o[n=2,h=y]." in found.warnings[0]
    assert not found.items


def test_problems_without_every_combination_are_left_out(make, tmp_path):
    found = section(make(tmp_path / "s", ("p", "q"), tuple(OPTIONS), options=OPTIONS, skip=[("q", "o[n=1,h=x]")]))
    assert found.warnings == ("Left out, as a combination of o has no trial: q.",)
    none = make(tmp_path / "n", ("p",), tuple(OPTIONS), options=OPTIONS, skip=[("p", "o[n=1,h=x]")])
    assert "No problem has trials of every combination of o." in section(none).text


def test_two_sweeps_are_two_subsections(make, tmp_path):
    both = OPTIONS | {f"w[k={k}]": {"k": k} for k in (1, 2, 3)}
    found = section(make(tmp_path / "s", SEVEN, tuple(both), options=both))
    assert [each.title for each in found.sections] == ["o", "w"]
    assert len(found.sections[1].items) == 4
