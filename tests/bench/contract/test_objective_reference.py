"""The objective equals a literal implementation to the last bit, however points are split into calls."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench import BudgetExhausted, FunctionProblem, Problem
from tests.bench.objectives import objective

pytestmark = pytest.mark.usefixtures("scanner")  # compiled and interpreted


class Reference:
    """What an objective does, one row after the other and as plainly as it can be said."""

    def __init__(self, problem, budget, on_refusal):
        self.problem, self.budget, self.on_refusal = problem, budget, on_refusal
        self.nfev = self.outside_box = self.refusals = 0
        self.fun, self.best_point = np.inf, None
        self.trace = []

    def __call__(self, x):
        points = self.floats(x, "points")
        rows = [points] if points.ndim == 1 else list(points) if points.ndim == 2 else None
        d = len(self.problem.lower)
        if rows is None or points.shape[-1] != d:
            raise ValueError(f"expected points of shape (n, {d}) or ({d},), got {points.shape}")
        allowed = rows[: self.budget - self.nfev]
        worth = self.evaluate(allowed) if allowed else []
        if len(allowed) < len(rows):
            self.refusals += 1
            self.on_refusal(self.refusals)
            raise BudgetExhausted
        return worth[0] if points.ndim == 1 else np.array(worth, dtype=np.float64)

    def evaluate(self, rows):
        values = self.floats(self.problem.evaluate(np.array(rows)), f"values of problem {self.problem.name!r}")
        if values.shape != (len(rows),):
            raise ValueError(f"problem {self.problem.name!r} returned shape {values.shape} for {len(rows)} points")
        if -np.inf in values.tolist():
            raise ValueError(f"problem {self.problem.name!r} returned -inf; a value must be finite or +inf")
        worth = []
        for row, value in zip(rows, values.tolist(), strict=True):
            inside = all(a <= c <= b for a, c, b in zip(self.problem.lower, row, self.problem.upper, strict=True))
            self.nfev += 1
            self.outside_box += not inside
            worth.append(value if inside and not np.isnan(value) else np.inf)
            if worth[-1] < self.fun:
                self.trace.append((self.nfev, worth[-1]))
            if worth[-1] < self.fun or self.best_point is None:
                self.fun, self.best_point = worth[-1], row.copy()
        return worth

    def floats(self, given, what):
        array = np.asarray(given)
        if array.dtype.kind not in "fiubO":
            raise TypeError(f"{what} must be real numbers, not {array.dtype}")
        return np.array(array, dtype=np.float64)


class Scripted(Problem):
    """A problem that returns the values of a script, and keeps the points that it received."""

    name = "scripted"

    def __init__(self, d):
        self.lower, self.upper = np.full(d, -5.0), np.arange(5.0, 5.0 + d)
        self.given, self.answer = [], None

    def evaluate(self, x):
        self.given.append((x.tobytes(), x.shape, x.dtype, x.flags.c_contiguous, x.flags.writeable))
        return self.answer(x)


def unaligned(x):
    return np.frombuffer(b"0" + x.tobytes(), np.uint8)[1:].view(np.float64).reshape(x.shape)


def strided(x):
    return np.repeat(x, 2, axis=-1)[..., ::2]


def read_only(x):
    x = x.copy()
    x.flags.writeable = False
    return x


FORMS = {
    "array": np.array, "Fortran": np.asfortranarray, "strided": strided, "backwards": lambda x: x[..., ::-1],
    "unaligned": unaligned, "read-only": read_only, "list": np.ndarray.tolist, "tuple": tuple, "big-endian":
    lambda x: x.astype(">f8"), "float32": lambda x: x.astype(np.float32), "long": lambda x: x.astype(np.longdouble),
    "object": lambda x: x.astype(object), "int": lambda x: np.nan_to_num(x, posinf=9, neginf=-9).astype(int),
    "bool": lambda x: x > 0, "subclass": lambda x: x.view(type("Subclass", (np.ndarray,), {})),
    "complex": lambda x: x.astype(complex), "text": lambda x: x.astype(str), "dates": lambda x: x.astype("M8[s]"),
    "deeper": lambda x: x[np.newaxis, np.newaxis], "column": lambda x: x[..., np.newaxis], "shorter":
    lambda x: x[..., 1:], "number": lambda x: x.sum(),
}  # fmt: skip
USUAL = st.sampled_from(["array", "array", "array", "array", "list", "strided", "read-only"])
COORDINATES = st.sampled_from(
    [-5.0, np.nextafter(-5.0, -9), np.nextafter(5.0, 9), 5.0, 0.0, -0.0, 5e-324, 2.5, 1e308, np.nan, np.inf, -np.inf]
) | st.floats(-5, 5)
VALUES = st.sampled_from([3.0, 2.0, 1.0, 0.0, -0.0, -5e-324, np.nan, np.inf]) | st.floats(-1e9, 1e9)


@st.composite
def calls(draw, dimension):
    """Return points, and a function that answers them as a problem would, or as it must not."""
    n = draw(st.sampled_from([None, None, 0, 1, 2, 5]))
    near, far = st.floats(-5, 5), COORDINATES
    rows = [[draw(draw(st.sampled_from([near, near, far]))) for _ in range(dimension)] for _ in range(n or n is None)]
    points = np.array(rows, dtype=np.float64).reshape((dimension,) if n is None else (n, dimension))
    values = np.array([draw(VALUES) for _ in range(6)])
    if draw(st.integers(0, 15)) == 0:
        values[draw(st.integers(0, 5))] = -np.inf
    form, answer = (draw(USUAL | st.sampled_from(sorted(FORMS))) for _ in range(2))
    moves, fails = draw(st.booleans()), draw(st.integers(0, 15)) == 0

    def evaluate(x):
        if moves:  # the problem writes into its argument
            x[:] = 0.25
        if fails:
            raise KeyError("fails")
        return FORMS[answer](values[: len(x)])

    with np.errstate(all="ignore"):
        return FORMS[form](points), evaluate


def outcome(objective, x):
    """Return the type and the bits of what a call returns, or the exception that it raises."""
    with np.errstate(all="ignore"):  # float32 is too narrow for some
        try:
            found = objective(x)
        except (BudgetExhausted, Exception) as error:
            return type(error), str(error)
    return type(found), np.asarray(found).dtype, np.shape(found), np.asarray(found).tobytes()


@pytest.mark.sampled(1)
@settings(max_examples=150)
@given(st.data())
def test_equals_the_literal_reference_to_the_last_bit(data):
    d, budget = data.draw(st.integers(1, 4)), data.draw(st.integers(1, 20))
    problems, refusals = (Scripted(d), Scripted(d)), ([], [])
    fast = objective(problems[0], budget, 0, refusals[0].append)
    plain = Reference(problems[1], budget, refusals[1].append)
    for x, answer in data.draw(st.lists(calls(d), min_size=1, max_size=12)):
        problems[0].answer = problems[1].answer = answer
        before = np.array(x).tobytes()
        assert outcome(fast, x) == outcome(plain, x)
        assert np.array(x).tobytes() == before
        assert (fast.nfev, fast.outside_box) == (plain.nfev, plain.outside_box)
        assert fast.remaining == budget - plain.nfev
        assert (type(fast.fun), repr(fast.fun)) == (float, repr(plain.fun))
        assert (fast.best_point is None) == (plain.best_point is None)
        if fast.best_point is not None:
            assert (fast.best_point.shape, fast.best_point.tobytes()) == ((d,), plain.best_point.tobytes())
        trace = fast.trace
        assert (trace.evaluations.dtype, trace.values.dtype) == (np.int64, np.float64)
        assert repr([*zip(trace.evaluations.tolist(), trace.values.tolist(), strict=True)]) == repr(plain.trace)
        assert problems[0].given == problems[1].given
        assert refusals[0] == refusals[1]


@pytest.mark.parametrize("seed", range(5))
def test_no_value_depends_on_how_the_points_are_split_into_calls(seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5.5, 5.5, (200, 3))
    table = {each.tobytes(): value for each, value in zip(points, rng.permutation(200), strict=True)}
    table[points[7].tobytes()] = np.nan
    problem = FunctionProblem(lambda x: [table[row.tobytes()] for row in x], [-5.0] * 3, [5.0] * 3)
    found = []
    for sizes in ([200], [1] * 200, rng.multinomial(200, [0.1] * 10)):
        f = objective(problem, budget=200)
        values = [f(part) for part in np.split(points, np.cumsum(sizes)[:-1])]
        found.append((np.concatenate(values).tolist(), f.trace.evaluations.tolist(), f.best_point.tolist()))
    f = objective(problem, budget=200)
    found.append(([f(point) for point in points], f.trace.evaluations.tolist(), f.best_point.tolist()))
    assert all(each == found[0] for each in found)
