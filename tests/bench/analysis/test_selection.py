"""The choice by features, and its validation by leaving functions out."""

import numpy as np
import pandas as pd
import pytest

from bench.analysis.selection import best_on, feature_distances, selection_gain, usual_reach, validated_selection

KINDS = 6  # problems on which a is good, and as many for b; each function has two problems


@pytest.fixture(scope="module")
def study():
    """Return scores of optimizers good on one kind of problem each, the functions, and a feature of the kind."""
    rows = [
        (f"{kind}{number}", optimizer, trial, 0.8 if kind == optimizer else 0.3)
        for kind in "ab"
        for number in range(KINDS)
        for optimizer in "abc"
        for trial in range(3)
    ]
    scores = pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "score"])
    problems = list(dict.fromkeys(scores["problem"]))
    features = pd.DataFrame(
        {
            "ela.kind": [float(problem[0] == "b") for problem in problems]
            + np.random.default_rng(0).normal(0, 0.01, len(problems)),
            "dimension": 2.0,
        },
        index=problems,
    )
    return scores, features, {problem: f"{problem[0]}-{int(problem[1]) // 2}" for problem in problems}


def test_the_feature_chooses_the_optimizer_of_its_kind(study):
    scores, features, blocks = study
    found = validated_selection(features, scores, scores, blocks)
    # four problems of its own kind are left, and one of the other
    assert (found["chosen"] == found["problem"].str[0]).all()
    mean, low, high = selection_gain(found)
    assert mean == pytest.approx(0.25)
    assert mean - low == pytest.approx(high - mean)


def test_no_problem_of_the_function_takes_part_in_its_choice(study):
    scores, features, blocks = study
    found = validated_selection(features, scores, scores, blocks)
    assert [blocks[own] for own in found["nearest"]] != list(found["function"])
    assert all(blocks[near] != function for near, function in zip(found["nearest"], found["function"], strict=True))


def test_the_sample_is_charged_to_the_choice_alone(study):
    scores, features, blocks = study
    paid = scores.assign(score=scores["score"] - 0.3)
    assert selection_gain(validated_selection(features, scores, paid, blocks))[0] == pytest.approx(-0.05)


def test_too_few_functions_are_not_validated(study):
    scores, features, blocks = study
    few = features[features.index.str[1].astype(int) < 4]
    found = validated_selection(few, scores, scores, blocks)
    assert found.empty
    assert np.isnan(selection_gain(found)).all()
    assert validated_selection(features.iloc[:0], scores, scores, blocks).empty


def test_equal_optimizers_gain_nothing(study):
    scores, features, blocks = study
    found = validated_selection(features, scores.assign(score=0.5), scores.assign(score=0.5), blocks)
    assert selection_gain(found) == (0, 0, 0)


def test_distances_are_of_no_unit_and_weigh_groups_alike():
    table = pd.DataFrame({"a.1": [0.0, 1.0, 0.0, 1.0], "a.2": [0.0, 1.0, 0.0, 1.0], "b.1": [0.0, 0.0, 1.0, 1.0]})
    apart = feature_distances(table, table).to_numpy()
    assert apart[0, 1] == pytest.approx(apart[0, 2])
    assert apart[0, 1] == pytest.approx(np.sqrt(4 / 2))  # two standard deviations in one of two groups
    moved = table.assign(**{"b.1": np.sinh(5 + 7 * np.arcsinh(table["b.1"]))})
    assert feature_distances(moved, moved).to_numpy() == pytest.approx(apart)


def test_missing_and_constant_features_do_no_harm():
    table = pd.DataFrame({"a.1": [0.0, 1.0, np.nan], "a.2": [3.0] * 3, "b.1": [np.nan] * 3})
    apart = feature_distances(table, table).to_numpy()
    assert np.isfinite(apart).all()
    assert apart[2, 0] == pytest.approx(apart[2, 1])
    one = table.iloc[:1]
    assert feature_distances(one, one).to_numpy() == pytest.approx(0)


def test_the_reach_is_measured_between_functions():
    table = pd.DataFrame({"a.1": [0.0, 0.1, 5.0]}, index=["f-1", "f-2", "g"])
    space = feature_distances(table, table)
    blocks = {"f-1": "f", "f-2": "f", "g": "g"}
    assert usual_reach(table, blocks) == pytest.approx(space.loc["f-1", "g"])
    assert np.isnan(usual_reach(table.iloc[:2], blocks))


def test_the_best_three_there_stand_beside_the_single_best(study):
    scores, _, blocks = study
    best = best_on(["b0", "b1", "b2"], scores, scores, blocks)
    assert best["optimizer"].to_list() == ["b", "a", "c"]
    first = best.iloc[0]
    assert (first["score"], first["gain"]) == (pytest.approx(0.8), pytest.approx(0.5))
    assert np.isfinite(first["low"])
    alone = best_on(["b0"], scores, scores, blocks)
    assert np.isnan(alone["low"]).all()
