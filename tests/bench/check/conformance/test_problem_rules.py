"""The rules of a problem: sound ones keep all, and each fault breaks a rule and is named with its remedy."""

import numpy as np
import pytest

import bench
from bench.check.conformance.problem_rules import check_search
from bench.check.conformance.problem_subject import ProblemSubject
from bench.check.conformance.recording import ViolationError
from bench.check.conformance.rules import PROBLEM_RULES, find_rule
from tests.bench.check import faulty_problems as faulty
from tests.bench.check.conformance.examine import InThisProcess, expect_broken, failures

HERE = [rule for rule in PROBLEM_RULES if rule.name != "processes"]


def verdicts(problem, rules=HERE):
    checker = InThisProcess(ProblemSubject.of(problem, {}, seed=0))
    return {verdict.check: verdict for verdict in filter(None, map(checker.verdict, rules))}


def test_every_rule_of_a_problem_has_a_name_of_its_own_and_stands_after_those_that_it_needs():
    names = [rule.name for rule in PROBLEM_RULES]
    assert len(set(names)) == len(names) == 17
    for number, rule in enumerate(PROBLEM_RULES):
        assert set(rule.needs) <= set(names[:number])
        assert find_rule(rule.name, "problem") is rule


@pytest.mark.parametrize(
    "problem", [faulty.Sound, faulty.Sound(), faulty.Noisy, faulty.Whole, "classical-sphere-d2-i1"]
)
def test_a_sound_problem_keeps_every_rule(problem):
    found = verdicts(problem)
    assert not failures(found)
    assert len(found) == len(HERE)


FAULTS = [
    (faulty.Endless, "declaration", "its optimum is inf", "None where none is known"),
    (faulty.Flat, "values", "returned shape (135, 1) for 135 points", "one float64 for each point"),
    (faulty.Ranked, "batches", "values differ alone, by up to", "no statistic of the batch"),
    (faulty.Mute, "noise", "it declares noise and returns the true values", "noisy = False"),
    (faulty.Coarse, "resolution", "as where numbers pass through float32", "float64 throughout"),
    (faulty.Idle, "variables", "no value or violation of 32 points changes with c", "leave it out"),
    (faulty.Chunked, "calls", "in a batch of 37, a point has another value", "however many"),
    (faulty.Local, "optimum", "a search from its optimum_point finds", "the lowest feasible value"),
    (faulty.Outside, "repair", "repaired points lie outside the box", "clip to the box"),
    (faulty.Keeping, "no state", "a run changes its 'measure'", "local variables"),
    (faulty.Drawing, "global states", "global random state of Python", "draw from rng alone"),
    (faulty.Chatty, "silence", "such as 'evaluated 24'", "print and log nothing"),
    (faulty.Littering, "leftovers", "such as 'log.txt'", "write no files"),
    (faulty.Renamed, "declaration", "have the names ('a', 'a', 'b')", "3 different names"),
    (faulty.Halves, "declaration", "integer variable 'a' is bounded by -4.5", "bounds"),
    (faulty.Whole32, "values", "its values are float32, not float64", "one float64"),
    (faulty.NotANumber, "values", "values are NaN, such as at [-", "+inf"),
    (faulty.Bottomless, "values", "values are -inf", "+inf"),
    (faulty.Counting, "batches", "64 of 64 values differ a second time", "no counter"),
    (faulty.Loose, "batches", "violations differ alone", "no statistic of the batch"),
    (faulty.Own, "noise", "the same generator gives other values", "draw the noise from rng alone"),
    (faulty.CoarsePoints, "resolution", "as where numbers pass through float32", "float64 throughout"),
    (faulty.CoarseInside, "resolution", "as where numbers pass through float32", "float64 throughout"),
    (faulty.RoundedPoints, "resolution", "one of 1e-10 0%", "no rounding of points"),
    (faulty.Wide, "calls", "a point has another value than in one of 256", "however many"),
    (faulty.Padded, "calls", "a point has another value than in one of 256", "however many"),
    (faulty.Tiring, "calls", "after 1,000 calls, in a batch of 1, a point", "were before"),
    (faulty.Drifting, "calls", "a point has another value", "were before"),
    (faulty.Unsearched, "optimum", "a search from the best random point finds", "the lowest feasible value"),
    (faulty.Restless, "repair", "points move when repaired again", "leave a point"),
    (faulty.Unrepaired, "repair", "although it declares repairs = True", "repairs = False"),
    (faulty.High, "optimum", "below the optimum of 20.0", "the lowest feasible value"),
    (faulty.Misplaced, "optimum", "its optimum_point has 1.0, not the optimum of 0.0", "where it is, or None"),
]
"""The first of them break a rule each; the others are slow."""


@pytest.mark.sampled(13)
@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize(("problem", "rule", "finding", "remedy"), FAULTS, ids=[case[0].__name__ for case in FAULTS])
def test_a_fault_breaks_its_rule_and_says_how_to_mend_it(problem, rule, finding, remedy, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expect_broken(verdicts(problem), rule, finding, remedy)


def test_a_matrix_product_that_rounds_one_row_otherwise_is_called_rounding():
    x = np.random.default_rng(1).uniform(-5, 5, (64, 23))
    if all(((row[None] @ faulty.ROTATION) == rows).all() for row, rows in zip(x, x @ faulty.ROTATION, strict=True)):
        pytest.skip("this linear algebra library rounds alike")
    (broken,) = failures(verdicts(faulty.Rotated))
    assert "by rounding alone" in broken.finding
    assert "sum products of elements" in broken.remedy


def test_equal_instances_of_a_suite_are_found():
    found = verdicts("star-discrepancy-sobol-10-d2-i1", [find_rule("instances", "problem")])
    assert "it has the values of star-discrepancy-sobol-10-d2-i2" in found["instances"].finding


def test_a_search_finds_what_lies_below_a_claimed_optimum_and_says_how_near_it_came():
    searches = ("cma-es", "missing:LSHADE")
    said = check_search(ProblemSubject(faulty.Sound), searches, 300)
    assert "cma-es ends" in said
    assert "not searched by missing:LSHADE: unknown" in said
    claimed = bench.FunctionProblem(faulty.Sound().values, [-5] * 3, [4] * 3, optimum=1e-6)
    with pytest.raises(ViolationError, match="below the optimum of 1e-06"):
        check_search(ProblemSubject(claimed), searches, 300)
