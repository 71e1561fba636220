"""What the tests of a study can find follows from its design, before any trial."""

import re

import numpy as np
import pytest
from scipy.stats import norm

from bench import Study
from bench.analysis import detectable_a12
from bench.analysis.across import p_of_means
from bench.analysis.direction import Effects, effects, p_values
from bench.analysis.error_rates import detectable_across, levels
from bench.topics.trials.design import foreseen

STUDY = {
    "name": "planned",
    "trials": 15,
    "budget": 100,
    "problems": [{"suite": "classical", "functions": ["sphere", "rastrigin"], "dimensions": [2], "instances": "1"}],
    "optimizers": [{"name": "gwo"}, {"name": "alo"}, {"name": "random-search"}],
}


def found(line):
    return [float(number) for number in re.findall(r"A12 of (\d\.\d+)", line)]


def test_it_is_what_the_first_of_all_tests_finds():
    design, line, *_ = foreseen(Study.from_dict(STUDY))
    assert design.startswith("The design: 3 optimizers, 2 problems, 15 trials of each on a problem; no result is known")
    level = levels([15, 15], 3, 6).problems / 6
    assert found(line)[0] == pytest.approx(detectable_a12(15, level), abs=0.02)


def test_more_trials_find_smaller_differences_and_so_do_more_problems_over_all_of_them():
    _, now, trials, problems = foreseen(Study.from_dict(STUDY))
    assert found(trials)[0] < found(now)[0]
    assert found(trials)[1] < found(now)[1]
    assert found(problems)[1] < found(now)[1]
    assert found(problems)[0] >= found(now)[0]  # each has a smaller share of the level


def test_instances_of_a_function_are_trials_of_one_problem():
    problems = [{"suite": "classical", "functions": ["sphere"], "dimensions": [2], "instances": "1-3"}]
    design, _, more, _ = foreseen(Study.from_dict(STUDY | {"problems": problems}))
    assert "1 problem, 45 trials of each on a problem (15 on each of 3 instances)" in design
    assert more.startswith("With 10 more trials on each instance, 75 on a problem: ")


def test_a_subject_is_tested_against_its_rivals_alone_and_finds_more():
    lines, own = foreseen(Study.from_dict(STUDY)), foreseen(Study.from_dict(STUDY | {"subject": "gwo"}))
    assert "gwo against each other one" in own[0]
    assert found(own[1])[0] <= found(lines[1])[0]


def test_too_few_trials_find_nothing_on_a_problem():
    (_, now, *_) = foreseen(Study.from_dict(STUDY | {"trials": 3}))
    assert "on a single problem nothing, where 11 trials of each are the fewest that can be significant" in now
    assert "nothing" not in foreseen(Study.from_dict(STUDY | {"trials": 11}))[1]


def test_the_foreseen_power_is_that_of_new_draws_within_three_hundredths():
    level, rng = levels([15, 15], 3, 6), np.random.default_rng(7)
    single = detectable_a12(15, level.problems / 6, 0.8)
    across = detectable_across(15, 2, level.across / 3, 0.8)
    assert [f"{single:.2f}", f"{across:.2f}"] == [f"{each:.2f}" for each in found(foreseen(Study.from_dict(STUDY))[1])]

    def drawn(a12, pairs):
        this, other = rng.standard_normal((2, pairs, 15))
        return effects(this, other + np.sqrt(2) * norm.ppf(a12))

    assert np.mean(p_values(drawn(single, 10_000)) <= level.problems / 6) == pytest.approx(0.8, abs=0.03)
    both = drawn(across, 20_000)
    estimates = Effects(both.a12.reshape(2, -1), both.ratio.reshape(2, -1), np.full((2, 10_000), 15))
    assert np.mean(p_of_means(estimates) <= level.across / 3) == pytest.approx(0.8, abs=0.03)
