"""Integrity: sound results pass every check, and each planted trap is found by its own check and no other."""

import re
import warnings

import numpy as np
import pandas as pd
import pytest

from bench.analysis.cells import in_study_order
from bench.analysis.integrity import TRAITS, integrity
from bench.contract.objective import Trace
from bench.study import Entry, Study

BUDGET, TRIALS = 1_000, 6
PROBLEMS, OPTIMIZERS = ("p", "q"), ("a", "b", "c")
BOXES = {"p": {"u": (-1.0, 1.0), "v": (0.0, 10.0)}, "q": {"v": (0.0, 5.0), "u": (-2.0, 0.0)}}
OPTIMA = {"p": 0.5, "q": -1e12}
CHECKS = [
    "completeness", "failures", "storage", "repeatability",
    "centre bias", "structural bias", "boundary clamping", "starts and seeds",
    "records", "undeclared stops", "repeated points", "ties", "below the optimum", "same algorithm", "seeds", "times",
]  # fmt: skip


class Sound:
    """Results without fault, and how to spoil them."""

    def __init__(self):
        rng = np.random.default_rng(1)
        rows = [
            {"problem": problem, "optimizer": optimizer, "trial": trial}
            for problem in PROBLEMS
            for optimizer in OPTIMIZERS
            for trial in range(TRIALS)
        ]
        n = len(rows)
        self.frame = pd.DataFrame(rows).assign(
            study="s", seed=rng.permutation(n), status="ok", fun=rng.uniform(1, 2, n), nfev=BUDGET, wall_s=1.0,
            cpu_s=1.0, objective_s=0.5, stop="budget", outside_box=0, error=None,
        )  # fmt: skip
        for name in ("u", "v"):
            lower, upper = np.array([BOXES[problem][name] for problem in self.frame["problem"]]).T
            self.frame[f"x_{name}"] = rng.uniform(lower, upper)
        self.traces = {
            key: Trace(np.array([1, 10 + i]), np.array([3 + rng.random(), fun]))
            for i, (*key, fun) in enumerate(
                self.frame[["problem", "optimizer", "trial", "fun"]].itertuples(index=False, name=None)
            )
            for key in [tuple(key)]
        }

        self.diagnoses = {
            name: [{"check": check, "passed": True, "figure": 1.0} for check in TRAITS] for name in OPTIMIZERS
        }

        self.verifications = [{"sentence": "12 of 12 trials of 6 cells are the same", "different": []}]
        self.stored = n

    def diagnose(self, optimizer, check, figure):
        """Have an optimizer found to have a trait."""
        others = [each for each in self.diagnoses[optimizer] if each["check"] != check]
        self.diagnoses[optimizer] = [*others, {"check": check, "passed": False, "figure": figure}]

    def put(self, where, **values):
        for column, value in values.items():
            self.frame[column] = self.frame[column].astype(object)
            self.frame.loc[where, column] = value
            self.frame[column] = self.frame[column].infer_objects()
        return self

    def trial(self, problem, optimizer, trial):
        same = (self.frame["problem"] == problem) & (self.frame["optimizer"] == optimizer)
        return same & (self.frame["trial"] == trial)

    def copy(self, source, target, *, trace=False):
        """Give one trial the final point and value of another, with or without its trace."""
        row = self.frame[self.trial(*source)].iloc[0]
        self.put(self.trial(*target), x_u=row["x_u"], x_v=row["x_v"])
        if trace:
            self.put(self.trial(*target), fun=row["fun"])
            self.traces[target] = self.traces[source]

    def check(self, **changes):
        given = {
            "study_budget": BUDGET,
            "planned_trials": TRIALS,
            "traces": self.traces,
            "boxes": BOXES,
            "optima": OPTIMA,
            "diagnoses": self.diagnoses,
            "verifications": self.verifications,
            "stored": self.stored,
        }
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return integrity(self.frame, **(given | changes)).set_index("check")


@pytest.fixture
def sound():
    return Sound()


def test_sound_results_pass_every_check(sound):
    table = sound.check()
    assert list(table.index) == CHECKS
    assert list(table) == ["verdict", "finding", "cells"]
    assert set(table["verdict"]) == {"pass"}
    assert set(table["cells"]) == {""}
    assert table["finding"].str.endswith(".").all()
    assert "36, 6 in each cell" in table.at["completeness", "finding"]


def test_what_cannot_be_checked_says_so(sound):
    verdicts = sound.check(traces=None, boxes=None, diagnoses=None, verifications=[], stored=0)["verdict"]
    unchecked = ["storage", "repeatability", *TRAITS, "same algorithm"]
    assert list(verdicts.index[verdicts == "not checked"]) == unchecked
    assert set(verdicts.drop(unchecked)) == {"pass"}


TRAPS = {}


def trap(check, verdict, *fragments, cells=None):
    """Register a function that spoils results: which check must find it, and what the finding must say."""

    def register(spoil):
        TRAPS[spoil.__name__] = (spoil, check, verdict, fragments, cells)
        return spoil

    return register


@trap("completeness", "warning", "2 of 36 planned trials", "0 of 6 cells", "4 to 6", "a on p", cells="a on p")
def two_trials_missing(s):
    s.frame = s.frame[~(s.trial("p", "a", 4) | s.trial("p", "a", 5))]


@trap("completeness", "warning", "6 of 36 planned trials", "1 of 6 cells", "c on q", cells="c on q")
def an_empty_cell(s):
    s.frame = s.frame[~((s.frame["problem"] == "q") & (s.frame["optimizer"] == "c"))]


def test_each_optimizer_has_its_own_plan(sound):
    """Imported results have more trials than ours, or fewer, and no plan that is known."""
    planned = {(problem, optimizer): TRIALS for problem in PROBLEMS for optimizer in OPTIMIZERS}
    sound.frame = sound.frame[~((sound.frame["optimizer"] == "c") & (sound.frame["trial"] > 1))]
    found = sound.check(planned_trials=planned | {("p", "c"): 0, ("q", "c"): 0}).loc["completeness"]
    assert found["verdict"] == "pass"
    assert "28, 2 to 6 in each cell" in found["finding"]
    sound.frame = sound.frame[~((sound.frame["optimizer"] == "c") & (sound.frame["problem"] == "q"))]
    found = sound.check(planned_trials=planned | {("p", "c"): 0, ("q", "c"): 0}).loc["completeness"]
    assert (found["verdict"], found["cells"]) == ("warning", "c on q")
    assert "0 of 26 planned trials are missing and 1 of 6 cells are empty" in found["finding"]


@trap("repeatability", "error", "11 of 12 trials", "different: a on p, trial 3", "more than their seeds")
def a_trial_that_is_not_repeated(s):
    s.verifications = [{"sentence": "11 of 12 trials are the same", "different": ["different: a on p, trial 3"]}]


@trap("repeatability", "not checked", "Run 'bench verify'")
def one_of_two_folders_not_verified(s):
    s.verifications += [{}]


@trap("failures", "error", "2 of 36 trials did not finish (", "failed 1", "timeout 1", "in a on p, b on q. They")
def failed_trials(s):
    nothing = {"fun": None, "nfev": None, "stop": None, "x_u": None, "x_v": None, "cpu_s": None, "wall_s": None}
    s.put(s.trial("p", "a", 0), status="failed", **nothing).put(s.trial("q", "b", 0), status="timeout", **nothing)
    del s.traces["p", "a", 0], s.traces["q", "b", 0]


def test_trials_that_the_problem_s_own_code_ended_are_no_optimizer_s_failures(sound):
    sound.put(sound.trial("p", "a", 0), status="failed", error="ProblemError: ValueError: no mass")
    del sound.traces["p", "a", 0]
    found = sound.check().loc["failures"]
    assert found["verdict"] == "pass"
    assert "All trials finished but 1 trial that ended as the problem’s own code raised.\n" in found["finding"]


@trap("centre bias", "warning", "b 50 times", cells="")
def an_optimizer_that_is_drawn_to_the_centre(s):
    s.diagnose("b", "centre bias", 50.0)


@trap("structural bias", "warning", "not uniform in the box: a p = 2e-09, b p = 0.001. Results", cells="")
def optimizers_that_favour_places(s):
    s.diagnose("a", "structural bias", 2.3e-9)
    s.diagnose("b", "structural bias", 1e-3)


@trap("boundary clamping", "warning", "on a bound of the box", "c 12.5% of them", cells="")
def an_optimizer_that_clips(s):
    s.diagnose("c", "boundary clamping", 0.125)


@trap(
    "starts and seeds", "warning", "different seeds are equal: a, c p = 1e-05. Trials may not be independent.", cells=""
)
def an_optimizer_that_repeats_itself_and_one_that_starts_in_a_corner(s):
    s.diagnose("a", "starts and seeds", None)
    s.diagnose("c", "starts and seeds", 1e-5)


@trap("failures", "warning", "1 of 36 trials", "c on q", cells="c on q")
def a_final_value_that_is_no_number(s):
    s.put(s.trial("q", "c", 1), fun=float("nan"))


@trap("failures", "warning", "1 of 36 trials", "c on q")
def an_infinite_final_value(s):
    s.put(s.trial("q", "c", 1), fun=float("inf"))
    s.traces["q", "c", 1] = Trace(np.array([], dtype=np.int64), np.array([]))


@trap("records", "error", "1 of 36 trials", "budget of 1,000", "a on q")
def more_evaluations_than_the_budget(s):
    s.put(s.trial("q", "a", 2), nfev=BUDGET + 1)


@trap("records", "error", "1 of 36 trials", "b on p")
def a_final_value_that_its_trace_does_not_know(s):
    s.put(s.trial("p", "b", 2), fun=0.5)


@trap("records", "error", "1 of 36 trials", "b on p")
def a_trace_longer_than_the_evaluations(s):
    last = s.traces["p", "b", 2]
    s.traces["p", "b", 2] = Trace(np.array([1, BUDGET + 1]), last.values)


@trap("records", "error", "1 of 36 trials", "b on p")
def a_finished_trial_without_a_trace(s):
    del s.traces["p", "b", 2]


@trap("undeclared stops", "warning", "2 of 36 trials", "more than 1%", "b on 2 problems", cells="b on p; b on q")
def a_silent_end(s):
    s.put(s.trial("p", "b", 2), nfev=989, stop="undeclared").put(s.trial("q", "b", 2), nfev=100, stop="budget")


@trap("repeated points", "error", "2 of 36 trials", "b on p", cells="b on p")
def one_final_point_from_two_seeds(s):
    s.copy(("p", "b", 1), ("p", "b", 4))


@trap("ties", "warning", "6 of 36 trials end at few different values, in b on p. Fewer than 50%", cells="b on p")
def most_trials_end_at_one_value_but_for_rounding(s):
    for trial in range(5):
        key = ("p", "b", trial)
        s.put(s.trial(*key), fun=1.5 * (1 + trial * 1e-14))
        s.traces[key] = Trace(s.traces[key].evaluations, np.array([s.traces[key].values[0], 1.5 * (1 + trial * 1e-14)]))


@trap("below the optimum", "warning", "1 of 36 trials ended below the known optimum, in b on p. That value or the")
def a_value_below_the_optimum_by_more_than_rounding(s):
    for trial, fun in ((1, 0.5 - 1e-12), (2, 0.5 - 1.5e-9)):
        key = ("p", "b", trial)
        s.put(s.trial(*key), fun=fun)
        s.traces[key] = Trace(s.traces[key].evaluations, np.array([s.traces[key].values[0], fun]))


@trap("same algorithm", "warning", "2 of 36 trials", "a on p, c on p", cells="a on p; c on p")
def one_algorithm_under_two_names(s):
    s.copy(("p", "a", 1), ("p", "c", 3), trace=True)


@trap("boundary clamping", "warning", "b 8.33% (v 16.7%)", cells="b on q")
def points_on_a_bound(s):
    s.put(s.trial("q", "b", 1), x_v=5.0 - 1e-13).put(s.trial("q", "b", 2), x_v=0.0)


@trap("boundary clamping", "warning", "a 12.5% (u 16.7%, v 8.33%), c 4.17% (u 8.33%)")
def two_worst_variables(s):
    s.put(s.trial("p", "a", 1), x_u=-1.0).put(s.trial("q", "a", 1), x_u=-2.0, x_v=5.0)
    s.put(s.trial("p", "c", 1), x_u=1.0)


@trap("seeds", "error", "2 of 36 trials", "the same optimizer", "b on 2 problems")
def a_seed_used_twice_by_one_optimizer(s):
    s.put(s.trial("p", "b", 1), seed=77_000).put(s.trial("q", "b", 1), seed=77_000)


@trap("seeds", "warning", "2 of 36 trials", "another optimizer", "a on p, b on p")
def a_seed_used_by_two_optimizers(s):
    s.put(s.trial("p", "a", 1), seed=77_000).put(s.trial("p", "b", 3), seed=77_000)


@trap("seeds", "warning", "12 of 36 trials", "a on p, b on p", cells="a on p; b on p")
def two_optimizers_draw_from_one_stream(s):
    for trial in range(TRIALS):
        first, own = s.traces["p", "a", trial], s.traces["p", "b", trial]
        s.traces["p", "b", trial] = Trace(own.evaluations, np.array([first.values[0], own.values[1]]))


@trap("times", "warning", "b 1.25", "1.2 times")
def trials_that_waited_for_a_core(s):
    s.put(s.frame["optimizer"] == "b", cpu_s=0.8)


@trap("times", "warning", "b 0.83", "1.1 times")
def trials_that_used_two_cores(s):
    s.put(s.frame["optimizer"] == "b", cpu_s=1.2)


@pytest.mark.parametrize("name", TRAPS)
def test_a_trap_is_found_by_its_own_check_only(sound, name):
    spoil, check, verdict, fragments, cells = TRAPS[name]
    spoil(sound)
    table = sound.check()
    assert table["verdict"].to_dict() == dict.fromkeys(CHECKS, "pass") | {check: verdict}
    for fragment in fragments:
        assert fragment in table.at[check, "finding"]
    if cells is not None:
        assert table.at[check, "cells"] == cells


def test_every_check_has_a_trap():
    storage = {"storage"}  # nothing is read of a damaged store
    assert {check for _, check, *_ in TRAPS.values()} == set(CHECKS) - storage
    assert len(CHECKS) <= 16  # as many as a reader takes in


def test_values_of_two_kinds_are_ties_which_tests_distinguish(sound):
    """0 and 1 are neither a ceiling nor without a difference: 0 in all trials is separable from 1 in all."""
    sound.frame["fun"] = (sound.frame["optimizer"] == "c").astype(float)
    said = sound.check(traces={}).at["ties", "finding"]
    assert "in every comparison a tie counts half" in said
    assert not re.search("ceiling|cannot be distinguished", said)


def test_instances_are_counted_as_such_beside_the_problems_that_they_belong_to(sound):
    for problem in PROBLEMS:
        for trial in range(5):
            key = (problem, "b", trial)
            sound.put(sound.trial(*key), fun=1.5)
    sound.frame.loc[(sound.frame["problem"] == "p") & (sound.frame["optimizer"] == "c"), "fun"] = 2.5

    def ties(**pool):
        frame = sound.frame.assign(pool=sound.frame["problem"].map(pool)) if pool else sound.frame
        return integrity(frame, study_budget=BUDGET, planned_trials=TRIALS).set_index("check").at["ties", "finding"]

    assert "in b on 2 problems, c on p." in ties()
    assert "in b on 2 problems, c on p." in ties(p="p", q="q")
    assert "in b on 2 instances of f, c on p." in ties(p="f", q="f")
    missing = sound.frame.drop(sound.frame.index[sound.frame["optimizer"] == "a"])
    found = integrity(in_study_order(missing, study_of()).assign(pool="f"), study_budget=BUDGET, planned_trials=TRIALS)
    assert "a on 2 instances of f." in found["finding"].iloc[0]


def study_of():
    """Return the study of all cells."""
    return Study("s", tuple(Entry("any", each) for each in PROBLEMS), tuple(Entry("any", each) for each in OPTIMIZERS))


class TestWhatIsNoTrap:
    def test_a_deterministic_start_is_no_shared_stream(self, sound):
        for optimizer in ("a", "b"):
            for trial in range(TRIALS):
                key = ("p", optimizer, trial)
                own = sound.traces[key]
                sound.traces[key] = Trace(own.evaluations, np.array([3.25, own.values[1]]))
        assert sound.check().at["seeds", "verdict"] == "pass"

    def test_a_start_that_two_trials_share_by_chance_is_no_shared_stream(self, sound):
        first, own = sound.traces["p", "a", 3], sound.traces["p", "b", 3]
        sound.traces["p", "b", 3] = Trace(own.evaluations, np.array([first.values[0], own.values[1]]))
        assert sound.check().at["seeds", "verdict"] == "pass"

    def test_equal_points_of_equal_seeds_are_the_seeds_fault(self, sound):
        sound.copy(("p", "b", 1), ("p", "b", 4), trace=True)
        sound.put(sound.trial("p", "b", 1) | sound.trial("p", "b", 4), seed=77_000)
        verdicts = sound.check()["verdict"]
        assert verdicts["seeds"] == "error"
        assert set(verdicts.drop("seeds")) == {"pass"}

    def test_an_early_end_within_one_percent_needs_no_reason(self, sound):
        sound.put(sound.trial("p", "b", 1), nfev=990, stop="undeclared")
        assert set(sound.check()["verdict"]) == {"pass"}


class TestWithoutTrials:
    @pytest.mark.parametrize("categories", [False, True])
    def test_an_empty_frame(self, sound, categories):
        entries = [[Entry(name, name) for name in names] for names in (PROBLEMS, OPTIMIZERS)]
        sound.frame = sound.frame.iloc[:0]
        if categories:
            sound.frame = in_study_order(sound.frame, Study("s", *map(tuple, entries), trials=TRIALS))
        verdicts = sound.check(traces={}, diagnoses={}, verifications=[], stored=0)["verdict"]
        assert verdicts["completeness"] == "warning"
        assert set(verdicts.drop("completeness")) == {"not checked"}


def test_clamping_here_and_in_separate_runs_is_one_finding(sound):
    points_on_a_bound(sound)
    sound.diagnose("c", "boundary clamping", 0.125)
    found = sound.check().loc["boundary clamping"]
    assert found["verdict"] == "warning"
    separate, here = found["finding"].splitlines()
    assert "c 12.5% of them" in separate
    assert "b 8.33%" in here


def test_a_test_that_did_not_reject_is_no_proof(sound):
    text = "No run repeated one with another seed, and the tests did not reject uniform and independent starts for "
    assert sound.check().at["starts and seeds", "finding"] == f"{text}any of the 3 optimizers."
    for name, figure in (("b", None), ("c", None)):  # whose runs all began at one point
        sound.diagnoses[name] = [each | {"figure": figure} for each in sound.diagnoses[name]]
    assert sound.check().at["starts and seeds", "finding"] == f"{text}a. There was nothing to test for b, c."
