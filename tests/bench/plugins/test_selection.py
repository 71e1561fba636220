"""Selecting many problems by a pattern, or by functions, dimensions and instances of a suite."""

import pytest

from bench import BenchError, Study
from bench.plugins import selection
from bench.plugins.selection import matching, selected

OPTIMIZERS = [{"name": "random-search"}]


def study(*problems):
    return Study.from_dict({"name": "s", "problems": list(problems), "optimizers": OPTIMIZERS})


def test_a_pattern_stands_for_all_functions_and_fifteen_instances():
    names = matching("bbob-f*-d5-*")
    assert len(names) == len(set(names)) == 24 * 15
    assert (names[0], names[-1]) == ("bbob-f01-d5-i1", "bbob-f24-d5-i15")
    assert matching("bbob-f0[13]-d?-i15") == [f"bbob-f0{function}-d{d}-i15" for function in (1, 3) for d in (2, 3, 5)]


def test_a_pattern_searches_families_without_a_grid_by_the_names_that_they_list():
    assert matching("signature-0[12]") == ["signature-01", "signature-02"]


def test_a_name_is_no_pattern_nor_is_a_path():
    for name in ("bbob-f01-d5-i99", "nothing", "recording:joint[2]*.csv"):
        assert matching(name) == [name]


def test_a_broken_family_hides_no_other(install):
    install("broken_family", "bench.problems", {"cec2000": "broken"}, "raise OSError")
    assert len(matching("cec20*-f03-d10")) == 4
    assert matching("bbob-f01-d2-i1?")[-1] == "bbob-f01-d2-i15"


@pytest.mark.parametrize(
    ("chosen", "count", "ends"),
    [
        ({"functions": "1-24", "dimensions": [2, 5, 10], "instances": "1-15"}, 1080, ("f01-d2-i1", "f24-d10-i15")),
        ({"functions": [1, "3-5"], "dimensions": 5, "instances": [7]}, 4, ("f01-d5-i7", "f05-d5-i7")),
        ({"functions": ["f02", 1, "1-2"], "dimensions": "2-5", "instances": "3, 77"}, 12, ("f02-d2-i3", "f01-d5-i77")),
        ({"instances": 200_000}, 144, ("f01-d2-i200000", "f24-d40-i200000")),
        ({}, 24 * 6 * 15, ("f01-d2-i1", "f24-d40-i15")),
    ],
)
def test_a_selection_is_the_product_of_what_is_chosen(chosen, count, ends):
    names = selected("bbob", **chosen)
    assert len(names) == len(set(names)) == count
    assert (names[0], names[-1]) == tuple(f"bbob-{end}" for end in ends)


def test_a_range_leaves_out_what_there_is_not():
    assert len(selected("cec2017", "1-30", 10)) == 29
    assert selected("cec2020", "5-7", 5) == ["cec2020-f05-d5"]


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        (("bbop",), "unknown suite 'bbop'; did you mean 'bbob'?"),
        ((["bbob"],), "unknown suite ['bbob']"),
        (("signature",), "the problems of 'signature' are no suite with functions and dimensions; give their names"),
        (("bbob", "1-25"), "bbob has no function '1-25'; it has f01 to f24"),
        (("bbob", 0), "bbob has no function 0; it has f01 to f24"),
        (("bbob", "24-1"), "bbob has no function '24-1'"),
        (("bbob", True), "bbob has no function True"),
        (("bbob", {"a": 1}), "bbob has no function {'a': 1}"),
        (("bbob", []), "a list of functions is empty; leave it out to select all"),
        (("bbob", None, [2, 4]), "bbob has no dimension 4; it has 2, 3, 5, 10, 20, 40"),
        (("bbob", None, 2.0), "bbob has no dimension 2.0"),
        (("bbob", None, None, "0-5"), "bbob has no instance '0-5'; it has 1 to 200000"),
        (("bbob", None, None, "1-5000"), "the selection from bbob stands for more than 100,000 problems; select fewer"),
        (("cec2022", None, None, 1), "the problems of cec2022 have no instances; leave them out"),
        (("cec2020", 6, 5), "no function selected from cec2020 has any of the dimensions 5"),
    ],
)
def test_one_sentence_names_what_there_is_not(chosen, sentence):
    with pytest.raises(BenchError) as caught:
        selected(*chosen)
    assert sentence in str(caught.value)


def test_a_pattern_without_a_match_or_with_too_many_is_refused(monkeypatch):
    with pytest.raises(BenchError, match=r"no problem matches 'bbob-f25-\*'; 'bench list problems' shows the families"):
        matching("bbob-f25-*")
    monkeypatch.setattr(selection, "MOST", 100)
    with pytest.raises(BenchError, match=r"'bbob-\*' stands for more than 100 problems; select fewer"):
        matching("bbob-*")


def test_a_study_selects_from_a_suite():
    chosen = study({"suite": "bbob", "functions": [1, 8], "dimensions": 2, "instances": "1-2"}, {"name": "sphere-2"})
    assert [entry.label for entry in chosen.problems] == [
        "bbob-f01-d2-i1", "bbob-f01-d2-i2", "bbob-f08-d2-i1", "bbob-f08-d2-i2", "sphere-2",
    ]  # fmt: skip
    assert chosen.problems[0].options == {}


def test_a_study_names_patterns_and_keeps_what_they_stand_for(tmp_path):
    chosen = study({"names": ["bbob-f01-d2-*", "cec2022-f0?-d10"]})
    assert len(chosen.problems) == 15 + 9
    (tmp_path / "s.toml").write_text(chosen.to_toml())
    assert "*" not in chosen.to_toml()
    assert Study.load(tmp_path / "s.toml") == chosen


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"suite": "bbob", "name": "sphere-2"}, "has one of name, names, suite and problem"),
        ({"suite": "bbob", "functions": 25}, "bbob has no function 25"),
        ({"functions": "1-24"}, "needs a name"),
    ],
)
def test_a_table_that_makes_no_sense_is_refused(table, sentence):
    with pytest.raises(BenchError) as caught:
        study(table)
    assert sentence in str(caught.value)


def test_problems_join_a_study_on_the_command_line(bench_here, tmp_path):
    (tmp_path / "s.toml").write_text(study({"name": "sphere-2"}).to_toml())
    done = bench_here("run", "s.toml", "--problem", "bbob-f01-d2-*", "--problem", "sphere-3", "--dry-run", cwd=tmp_path)
    assert "17 problems" in done.stdout
    twice = bench_here("run", "s.toml", "--problem", "sphere-*", "--dry-run", cwd=tmp_path)
    assert twice.returncode == 2
    assert "'sphere-2' occurs twice among the problems" in twice.stderr


STARS = """
from bench import Grid

class Family:
    grid = Grid("stars", {"sun": (2, 3)}, instances=4)

    def names(self):
        return list(self.grid.names(instances=[1]))

family = Family()
"""


def test_another_package_s_family_may_have_a_grid(install):
    install("family_of_stars", "bench.problems", {"stars": "family"}, STARS)
    assert matching("stars-*-d3-*") == [f"stars-sun-d3-i{k}" for k in (1, 2, 3, 4)]
    assert selected("stars", "sun", 2, "9") == ["stars-sun-d2-i9"]
