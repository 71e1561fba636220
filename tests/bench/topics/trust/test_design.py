"""Which difference a study's trials can show, and how many a difference needs, follow from its design."""

import re

import numpy as np
import pytest
from scipy.stats import norm

from bench import Study
from bench.analysis import detectable_a12
from bench.analysis.direction import effects, p_values
from bench.analysis.power import detectable_across
from bench.topics.trust.design import foreseen

STUDY = {
    "name": "planned",
    "trials": 15,
    "budget": 100,
    "problems": [{"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2], "instances": "1"}],
    "optimizers": [{"name": "gwo"}, {"name": "alo"}, {"name": "random-search"}],
}


def numbers(line):
    """Return the numbers on a problem and over all problems that a line has."""
    return [float(number) for number in re.findall(r"(?:on a problem|over all problems) (\d[\d.]*\d|\d)", line)]


def planned(**changes):
    return foreseen(Study.from_dict(STUDY | changes))


def test_it_is_what_the_first_test_of_a_problem_and_each_over_all_find():
    design, shown, _ = planned()
    assert design == "The design: 3 optimizers, 2 problems, 15 trials of each on a problem."
    expected = detectable_a12(15, 0.05 / 3), detectable_across(15, 2, 0.05)
    assert numbers(shown) == [pytest.approx(a12, abs=0.005) for a12 in expected]


def test_the_trials_that_a_gap_needs_show_it_and_fewer_do_not():
    single, across = map(int, numbers(foreseen(Study.from_dict(STUDY), 0.7)[2]))
    for place, trials in enumerate((single, across)):
        assert numbers(planned(trials=trials + 1)[1])[place] <= 0.71
        assert numbers(planned(trials=trials - 2)[1])[place] > 0.69


def test_a_subject_is_tested_against_its_rivals_alone_and_finds_more():
    lines, own = planned(), planned(subject="gwo")
    assert "gwo against each other one" in own[0]
    assert numbers(own[1])[0] <= numbers(lines[1])[0]


def test_the_foreseen_power_is_that_of_new_draws_within_three_hundredths():
    level, rng = 0.05 / 3, np.random.default_rng(7)
    this, other = rng.standard_normal((2, 10_000, 15))
    drawn = effects(this, other + np.sqrt(2) * norm.ppf(detectable_a12(15, level, 0.8)))
    assert np.mean(p_values(drawn) <= level) == pytest.approx(0.8, abs=0.03)
