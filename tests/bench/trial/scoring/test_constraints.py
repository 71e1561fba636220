"""Constraints: what an optimizer sees of infeasible points under each handling, and that only feasible ones count."""

from itertools import pairwise

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Study, load_results, run, solve
from bench.execution.verify import verify
from bench.trial.scoring import objective, scored
from bench.trial.scoring.constraints import BARRIER, COEFFICIENT, DEFAULT

POINTS = np.array([[1.0, 2.0], [-1.0, 1.0], [-2.0, -1.0], [0.5, 0.0], [9.0, 0.0]])  # the last one outside the box


class Mirrored(FunctionProblem):
    """Its repair satisfies the constraints: it takes absolute values."""

    repairs = True

    def repair(self, x):
        return np.abs(x)


def quadrant(kind=FunctionProblem, fun=lambda x: x.sum(axis=1), violations=lambda x: -x, **options):
    """Return the sum of the coordinates, on which both must be at least 0."""
    return kind(fun, [-3.0] * 2, [3.0] * 2, violations=violations, **options)


def began(handling, problem=None, budget=100):
    return objective(scored(problem or quadrant(Mirrored), handling), budget, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("handling", "shown"),
    [
        ("death", [3.0, np.inf, np.inf, 0.5, np.inf]),
        ("penalty", [3.0, 0.0 + COEFFICIENT, -3.0 + 3 * COEFFICIENT, 0.5, np.inf]),
        ("lexicographic", [3.0, 2 * BARRIER, 4 * BARRIER, 0.5, np.inf]),
        ("repair", [3.0, 2.0, 3.0, 0.5, np.inf]),
    ],
)
def test_what_the_optimizer_sees(handling, shown):
    assert began(handling)(POINTS).tolist() == shown
    one = began(handling)
    assert [one(point) for point in POINTS] == shown
    assert (one.nfev, one.outside_box) == (5, 1)


@pytest.mark.parametrize("handling", ["death", "penalty", "lexicographic"])
def test_only_feasible_points_are_recorded(handling):
    f = began(handling, quadrant())
    f(POINTS[[2, 1]])
    assert (f.fun, f.trace.values.tolist()) == (np.inf, [])
    f(POINTS[[2, 0, 1]])
    f(POINTS[3])
    assert f.trace.evaluations.tolist() == [4, 6]  # the first feasible point is the first entry
    assert f.trace.values.tolist() == [3.0, 0.5]
    assert (f.fun, f.best_point.tolist()) == (0.5, [0.5, 0.0])


@pytest.mark.parametrize("handling", ["death", "penalty", "lexicographic"])
def test_without_a_feasible_point_the_least_violating_one_in_the_box_is_the_best(handling):
    f = began(handling, quadrant())
    f(POINTS[[4]])
    f(POINTS[[2]])
    f(POINTS[[4, 1, 2]])
    f(POINTS[2])
    assert (f.fun, f.best_point.tolist()) == (np.inf, [-1.0, 1.0])
    g = began(handling, quadrant())
    g(np.array([[-3.0, 1.0], [9.0, 0.0]]))  # a bound is of the box
    assert g.best_point.tolist() == [-3.0, 1.0]


def test_a_repaired_point_is_recorded_in_place_of_the_point():
    f = began("repair")
    f(np.array([[-2.0, -1.0], [-1.0, -0.5]]))
    assert (f.fun, f.best_point.tolist()) == (1.5, [1.0, 0.5])
    assert scored(quadrant(Mirrored), "repair").evaluate(f.best_point[None]).tolist() == [1.5]


def test_every_infeasible_point_is_worse_than_every_feasible_one():
    """Deb's order holds for values of any size, violations of any size and in any unit."""
    sizes = np.array([-1e300, -1.0, 0.0, 1e-300, 1.0, 1e99, 1e100, 1e101, 1e308])
    excess = np.array([5e-324, 1e-300, 1e-9, 1.0, 1e150])
    values, violations = (each.ravel() for each in np.meshgrid(sizes, [*excess, 0.0, -1.0]))
    problem = FunctionProblem(
        lambda x: values[x[:, 0].astype(int)], [0], [99], violations=lambda x: violations[x[:, 0].astype(int), None]
    )
    shown = began("lexicographic", problem)(np.arange(len(values), dtype=float)[:, None])
    feasible = violations <= 0
    assert shown[feasible].max() < shown[~feasible].min()
    ordered = shown[~feasible][np.argsort(violations[~feasible], kind="stable")]
    assert (np.diff(ordered) >= 0).all()
    for size, then in pairwise(sizes[:7]):  # feasible ones are as they are, below the barrier
        assert shown[feasible & (values == size)].max() < shown[feasible & (values == then)].min()


@pytest.mark.parametrize("handling", ["death", "penalty", "lexicographic"])
def test_points_without_a_value_or_a_violation(handling):
    fun = lambda x: np.where(x[:, 0] > 2, np.nan, x[:, 0])  # noqa: E731 - one line each
    f = began(handling, quadrant(fun=fun, violations=lambda x: np.where(x > 1.5, np.nan, -x)))
    assert f(np.array([[2.5, 0.0], [1.8, 0.0], [1.0, 1.0]])).tolist() == [np.inf, np.inf, 1.0]
    g = began(handling, quadrant(fun=fun))
    assert g(np.array([2.5, 0.0])) == np.inf
    assert g.trace.values.tolist() == []


def test_values_and_violations_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match="returned -inf"):
        began("penalty", quadrant(fun=lambda x: np.full(len(x), -np.inf)))([-1.0, 0.0])
    with pytest.raises(ValueError, match=r"returned shape \(1,\) for 2 points"):
        began("death", quadrant(fun=lambda x: np.zeros(1), vectorized=True))(POINTS[:2])
    with pytest.raises(ValueError, match=r"violations of shape \(1, 2\) for 2 points"):
        began("death", quadrant(violations=lambda x: -x[:1]))(POINTS[:2])
    with pytest.raises(ValueError, match=r"expected points of shape"):
        began("death")(np.zeros(3))


def test_what_cannot_be_handled():
    with pytest.raises(BenchError, match=r"choose another handling: death, penalty, lexicographic$"):
        scored(quadrant(), "repair")
    with pytest.raises(BenchError, match="its violations cannot be computed: ZeroDivisionError"):
        scored(quadrant(violations=lambda x: 1 / 0), "death")
    with pytest.raises(BenchError, match=r"returned violations of shape \(1,\) for 1 points"):
        scored(quadrant(violations=lambda x: -x[:, 0]), "death")
    with pytest.raises(BenchError, match=r"'constraints' must be one of .*, not 'deth'; did you mean 'death'\?"):
        solve(quadrant(), "scatter", budget=20, constraints="deth")


# studies

STUDY = {
    "name": "s", "trials": 2, "budget": 60,
    "problems": [{"name": "ring-2"}, {"name": "sphere-2"}], "optimizers": [{"name": "scatter"}, {"name": "early"}],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("handling", ["death", "penalty", "lexicographic"])
def test_a_run_stores_feasible_values_and_repeats_them_bit_by_bit(handling, tmp_path):
    path = tmp_path / "s"
    run(Study.from_dict(STUDY | {"constraints": handling}), path, n_jobs=1)
    frame = load_results(path)
    ring = frame[frame["problem"] == "ring-2"]
    assert (frame["status"] == "ok").all()
    assert (ring["fun"] >= 9).all()
    assert (ring["violation"] == 0).all()
    assert frame.loc[frame["problem"] == "sphere-2", "violation"].isna().all()
    assert not verify(path, trials=2, n_jobs=1).different


@pytest.mark.parametrize(("constrained", "kept"), [(True, None), (False, 0.5)])
def test_the_optimum_of_repaired_points_holds_where_no_handling_confines_all_alike(constrained, kept):
    problem = quadrant(integer=[True, False], **({} if constrained else {"violations": None}))
    problem.repaired_optimum = 0.5
    assert scored(problem, DEFAULT).repaired_optimum == kept
