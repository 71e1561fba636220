"""What a trial process answers is refused unless it can be the result of its trial; honest results pass to the bit."""

import base64
import json
from math import inf, nan, nextafter

import numpy as np
import pytest

from bench import FunctionProblem, Optimizer, load_optimizer
from bench.contract.objective import Trace, integer_flags
from bench.execution import answers
from bench.execution.answers import Box, RefusedError
from bench.execution.trial_process import as_answer
from bench.trial.columns import packed
from bench.trial.trial import as_row, search

BOX = Box(("a", "b"), np.array([-1.0, -1.0]), np.array([1.0, 2.0]), np.zeros(2, bool))
BUDGET = 60


def text(values, dtype="<f8"):
    return base64.b64encode(np.array(values, dtype=dtype).tobytes()).decode()


def trace(evaluations=(1, 4, 60), values=(3.0, 2.5, 0.125)):
    packed = Trace(np.array(evaluations, dtype=np.int64), np.array(values, dtype=np.float64)).packed()
    return base64.b64encode(packed).decode()


HONEST = {
    "x": text([0.5, -0.25]), "trace": trace(), "fun": 0.125, "nfev": 60, "calls": 3, "largest_call": 1, "failures": 0,
    "log": {"step": [[0, 0.5], [1, None]]}, "wall_s": 1.0, "cpu_s": 0.9, "objective_s": 0.5,
    "memory_mb": 3.0, "stop": "budget",
    "outside_box": 2, "altered": False, "metrics": {"radius": 0.5},
}  # fmt: skip


def read(**changes):
    return answers.row(HONEST | changes, BOX, BUDGET)


def test_an_answer_that_can_be_a_result_is_a_row():
    assert read() == packed({
        "status": "ok", "fun": 0.125, "nfev": 60, "calls": 3, "largest_call": 1, "failures": 0,
        "log": b'{"step": [[0, 0.5], [1, null]]}', "wall_s": 1.0, "cpu_s": 0.9, "objective_s": 0.5,
        "memory_mb": 3.0, "stop": "budget",
        "outside_box": 2, "x": {"a": 0.5, "b": -0.25}, "metrics": {"radius": 0.5},
        "trace": Trace(np.array([1, 4, 60]), np.array([3.0, 2.5, 0.125])),
    })  # fmt: skip


WRONG = ["missing", None, [], {}, True, "text", b"bytes", 10**400, nan, "\ud800", [0.5]]
TEXTS = [("stop", "text"), ("stop", "\ud800"), ("log", {})]
PAIRS = [
    (name, value)
    for name in HONEST
    if name not in ("altered", "metrics")
    for value in WRONG
    if (name, value) not in TEXTS
]


@pytest.mark.parametrize(("name", "value"), PAIRS)
def test_a_field_that_is_missing_or_of_another_type_is_refused(name, value):
    answer = HONEST | {name: value}
    if value == "missing":
        del answer[name]
    with pytest.raises(RefusedError, match=f"its {name}|the values of its trace"):
        answers.row(answer, BOX, BUDGET)


NOWHERE = {"x": text([nan, nan]), "fun": inf, "trace": ""}
STOPPED = {"nfev": 59, "trace": trace([1, 4, 59]), "stop": "tired"}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"nfev": 61}, "its nfev is 61, and must be from 1 to 60"),
        ({"nfev": 0}, "its nfev is 0, and must be from 1"),
        ({"nfev": -(2**70)}, "its nfev is -1180591620717411303424, and must"),
        ({"nfev": 60.0}, "its nfev is no whole number"),
        ({"log": {"a": [[61, 1.0]]}}, "its log cannot be read"),
        ({"log": {"a": [[1, inf]]}}, "its log cannot be read"),
        ({"log": {"a": [[1, True]]}}, "its log cannot be read"),
        ({"log": {"a": [[1, 1.0]] * 201}}, "its log cannot be read"),
        ({"log": {str(number): [] for number in range(21)}}, "its log cannot be read"),
        ({"log": {"a": [[2, 1.0], [2, 1.0]]}}, "the evaluations of its log do not increase"),
        ({"calls": 0}, "its calls is 0, and must be from 1 to 60"),
        ({"calls": 61}, "its calls is 61, and must be from 1 to 60"),
        ({"outside_box": 61}, "its outside_box is 61, and must be from 0 to 60"),
        ({"outside_box": -1}, "its outside_box is -1, and"),
        ({"fun": 1}, "its fun is no number"),
        ({"fun": 0.1}, "its trace ends at 0.125, its best value is 0.1"),
        ({"fun": nextafter(0.125, 0)}, "its trace ends at 0.125"),
        ({"fun": -inf}, "its trace ends at 0.125"),
        ({"fun": inf}, "its trace ends at 0.125"),
        ({"trace": trace(values=[3.0, 2.5, -inf]), "fun": -inf}, "values of its trace do not decrease"),
        ({"trace": trace(values=[inf, 2.5, 0.125])}, "values of its trace do not decrease"),
        ({"trace": trace(values=[3.0, nan, 0.125])}, "values of its trace do not decrease"),
        ({"trace": trace(values=[2.5, 3.0, 0.125])}, "values of its trace do not decrease"),
        ({"trace": trace(values=[2.5, 2.5, 0.125])}, "values of its trace do not decrease"),
        ({"trace": trace(values=[1.7e308, -1.7e308, 0.125])}, "values of its trace do not decrease"),
        ({"trace": trace([], [])}, "its trace is empty"),
        ({"trace": trace([], []), "fun": 1.0}, "its trace is empty"),
        ({"trace": text([0.125])}, "its trace cannot be read"),
        ({"trace": HONEST["trace"][:-4]}, "its trace cannot be read"),
        ({"trace": HONEST["trace"] + "AAAA"}, "its trace cannot be read"),
        ({"trace": "!" + HONEST["trace"][1:]}, "its trace cannot be read"),
        ({"trace": "\u0661" * 32}, "its trace cannot be read"),
        ({"trace": trace([0, 4, 60])}, "the evaluations of its trace"),
        ({"trace": trace([-5, 4, 60])}, "the evaluations of its trace"),
        ({"trace": trace([1, 4, 61])}, "the evaluations of its trace"),
        ({"trace": trace([1, 4, 4])}, "the evaluations of its trace"),
        ({"trace": trace([4, 1, 60])}, "the evaluations of its trace"),
        ({"trace": text([1.0, 4.0, 60.0, 3.0, 2.5, 0.125])}, "the evaluations of its trace"),
        # differences that increase only because they overflow
        ({"trace": trace([5, 2 - 2**63, -1, 60], [3, 2, 1, 0.125])}, "the evaluations of"),
        ({"x": text([0.5])}, "its best point has 1 values, in 2 dimensions"),
        ({"x": text([])}, "its best point has 0 values"),
        ({"x": text([0.5] * 3)}, "its best point has 3 values"),
        ({"x": text([1.5, 0.0])}, "its best point lies outside the box"),
        ({"x": text([0.5, nextafter(-1.0, -2)])}, "its best point lies outside the box"),
        ({"x": text([0.5, nan])}, "its best point lies outside the box"),
        ({"x": text([0.5, -inf])}, "its best point lies outside the box"),
        (NOWHERE, "its best point has values that are no numbers"),
        ({"wall_s": -0.1}, "its wall_s is"),
        ({"wall_s": inf}, "its wall_s is"),
        ({"cpu_s": -1.0}, "its cpu_s is"),
        ({"cpu_s": inf}, "its cpu_s is"),
        ({"objective_s": inf}, "its objective_s is"),
        ({"objective_s": -1e-9}, "its objective_s is"),
        ({"stop": "tired"}, "it stopped by 'tired' after 60 of 60 evaluations"),
        ({"stop": "undeclared"}, "it stopped by 'undeclared' after 60"),
        ({"stop": "\x1b" * 10**6}, "it stopped by .{0,60} after 60"),
        (STOPPED | {"nfev": 58}, "the evaluations of its trace"),
        (STOPPED | {"stop": "budget"}, "it stopped by 'budget' after 59 of 60 evaluations"),
    ],
)
def test_what_contradicts_itself_or_the_study_is_refused(changes, reason):
    with pytest.raises(RefusedError, match=reason) as refused:
        read(**changes)
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    "changes",
    [
        STOPPED, STOPPED | {"stop": ""}, {"outside_box": 60}, {"outside_box": 0}, {"cpu_s": 1e4}, {"metrics": {}},
        {"x": text([1.0, 2.0])}, {"x": text([-1.0, -1.0])}, {"objective_s": 1.0},
        {"trace": trace([1, 2, 3])},
        {"trace": trace([60], [0.125])},
        {"trace": trace([1, 2], [1.7e308, -1.7e308]), "fun": -1.7e308},
        {"fun": inf, "trace": "", "x": text([-2.0, 7.0])},  # no point inside the box
    ],
)  # fmt: skip
def test_what_an_honest_trial_may_answer_passes(changes):
    assert read(**changes)["fun"] == (HONEST | changes)["fun"]


def test_a_reason_to_stop_is_cut_and_printable():
    assert read(**STOPPED | {"stop": "\x1b" + "x" * 1000})["stop"] == "\ufffd" + "x" * 200 + "…"


@pytest.mark.parametrize(
    "metrics", [None, 5, [["radius", 1.0]], {"radius": "wide"}, {"radius": None}, {"radius": [1.0]}, {"radius": True}]
)
def test_metrics_are_numbers_by_name(metrics):
    with pytest.raises(RefusedError, match="the metrics of its best point are no numbers"):
        read(metrics=metrics)


@pytest.mark.parametrize("answer", [5, None, "text", [], [["fun", 1.0]]])
def test_an_answer_is_a_table_of_fields(answer):
    with pytest.raises(RefusedError, match="no table of fields"):
        answers.error(answer)


@pytest.mark.parametrize("reason", [5, None, ["no"], {"no": 1}])
def test_an_error_is_a_text(reason):
    with pytest.raises(RefusedError, match="its error is no text"):
        answers.error({"error": reason})


def test_an_error_is_cut_and_printable():
    assert answers.error({}) == ""
    assert answers.error({"error": "\x1b[31m\ud800" + "x" * 10**6}) == "\ufffd[31m\ufffd" + "x" * 3994 + "…"


# From a search to a result, through what crosses the channel


class Given(Optimizer):
    """Evaluates what it is given."""

    def __init__(self, *batches):
        self.batches = batches

    def minimize(self, objective, rng):
        for batch in self.batches:
            objective(np.array(batch))
        objective.stop(" ")


def through(result, problem, budget):
    answer = json.loads(json.dumps(as_answer(result)))
    assert answers.error(answer) == ""
    box = Box(problem.variables, problem.lower, problem.upper, integer_flags(problem))
    return answers.row(answer | {"metrics": {}}, box, budget)


def same(found, row):
    assert found == row
    assert [(type(value), repr(value)) for value in found.values()] == [
        (type(row[name]), repr(row[name])) for name in found
    ]


FUNCTIONS = {
    "sphere": lambda x: (x * x).sum(axis=1),
    "smallest": lambda x: np.arange(len(x), 0, -1) * 5e-324,
    "largest": lambda x: -1.7e308 * (np.abs(x[:, 0]) / 2),
    "negative zero": lambda x: np.full(len(x), -0.0),
    "infinite": lambda x: np.full(len(x), inf),
    "undefined": lambda x: np.where(x[:, 0] > 0, nan, x[:, 0]),
}


@pytest.mark.parametrize("optimizer", ["hill-climber", "scatter", "early", "random-search"])
@pytest.mark.parametrize("function", FUNCTIONS)
def test_honest_results_pass_to_the_last_bit(optimizer, function, testing_plugins):
    problem = FunctionProblem(FUNCTIONS[function], [-2.0, -3.0], [2.0, 3.0])
    for seed in range(5):
        result = search(problem, load_optimizer(optimizer), 40, seed)
        same(through(result, problem, 40), as_row(result, problem.variables))


@pytest.mark.parametrize(
    "batches",
    [
        [[[7.0, 0.0]]],
        [[[7.0, 0.0]], [[1.0, 1.0], [nan, 0.0]], [[0.5, 0.5]] * 37],
        [[[1.0, 1.0], [0.5, 1.0], [0.5, 1.0], [0.25, 1.0]]],
    ],
)
def test_honest_results_with_points_outside_the_box_pass(batches):
    problem = FunctionProblem(FUNCTIONS["sphere"], [-2.0, -3.0], [2.0, 3.0])
    result = search(problem, Given(*batches), 40, 1)
    same(through(result, problem, 40), as_row(result, problem.variables))


# Boxes


def test_a_box_is_read():
    given = {"variables": ["a", "b"], "lower": [-1.0, -inf], "upper": [0.1, 1e308], "integer": [False, True]}
    found = Box.of(given)
    assert (found.variables, found.lower.tolist()) == (("a", "b"), [-1.0, -inf])
    assert found.upper.tolist() == [0.1, 1e308]
    assert found.integer.tolist() == [False, True]


@pytest.mark.parametrize(
    "given",
    [
        None, 5, [], {}, {"variables": None}, {"variables": 5, "lower": [0.0], "upper": [1.0]},
        {"variables": [5], "lower": [0.0], "upper": [1.0]}, {"variables": ["a"], "lower": ["x"], "upper": [1.0]},
        {"variables": ["a"], "lower": [0.0], "upper": [1.0, 2.0]}, {"variables": ["a"], "lower": 0.0, "upper": 1.0},
        {"variables": ["a"], "lower": [[0.0]], "upper": [[1.0]]}, {"variables": ["a"], "lower": [{}], "upper": [1.0]},
        {"integer": []}, {"integer": [[True]]},
    ],
)  # fmt: skip
def test_what_is_no_box_is_refused(given):
    honest = {"variables": ["a"], "lower": [0.0], "upper": [1.0], "integer": [False]}
    with pytest.raises(RefusedError, match="bounds cannot be read"):
        Box.of(honest | given if isinstance(given, dict) and given else given)
