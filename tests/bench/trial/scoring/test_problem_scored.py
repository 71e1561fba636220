"""Noise and integer variables: what an optimizer sees of them, and what is recorded."""

import numpy as np
import pytest

from bench import BenchError, FunctionProblem, Study, load_results, run
from bench.execution.verify import verify
from bench.trial.scoring import Scored, objective, scored

POINTS = np.array([[0.4, 1.0], [2.6, -1.5], [-3.0, 3.0]])


def mixed(kind=FunctionProblem, **options):
    """Return the sum of squares over a whole number from -3 to 4 and a number from -3 to 3."""
    given = {"fun": lambda x: (x**2).sum(axis=1), "lower": [-3.0, -3.0], "upper": [4.0, 3.0], "integer": [True, False]}
    return kind(**given | options)


def noisy(**options):
    """Return the sphere in 2 variables with additive noise."""
    given = {
        "fun": lambda x, rng: (x**2).sum(axis=1) + rng.standard_normal(len(x)),
        "lower": [-3.0] * 2, "upper": [3.0] * 2, "noiseless": lambda x: (x**2).sum(axis=1),
    }  # fmt: skip
    return FunctionProblem(**given | options)


def began(problem, seed=0, budget=100):
    return objective(scored(problem, "death"), budget, np.random.default_rng(seed))


class TestNoise:
    def test_the_optimizer_sees_noise_and_the_true_value_is_recorded(self):
        f = began(noisy())
        seen = f(POINTS)
        true = (POINTS**2).sum(axis=1)
        assert (seen != true).all()
        assert np.abs(seen - true).max() < 6
        assert f.trace.values.tolist() == [true[0]]
        assert (f.fun, f.best_point.tolist()) == (true[0], POINTS[0].tolist())

    def test_the_best_point_is_the_one_with_the_lowest_true_value_however_it_looked(self):
        f = began(noisy(fun=lambda x, rng: -(x**2).sum(axis=1)))
        assert f(POINTS).tolist() == (-(POINTS**2).sum(axis=1)).tolist()
        assert f.best_point.tolist() == POINTS[0].tolist()

    def test_every_evaluation_draws_anew_and_the_seed_repeats_them(self):
        one, again, other = began(noisy()), began(noisy()), began(noisy(), seed=1)
        seen = [one(POINTS[0]) for _ in range(50)]
        assert len(set(seen)) == 50
        assert seen == [again(POINTS[0]) for _ in range(50)]
        assert seen != [other(POINTS[0]) for _ in range(50)]

    def test_constraints_hold_for_a_noisy_problem(self):
        f = objective(scored(noisy(violations=lambda x: -x[:, :1]), "lexicographic"), 10, np.random.default_rng(0))
        assert (f(POINTS) >= 1e100).tolist() == [False, False, True]
        assert f.trace.values.tolist() == [(POINTS[0] ** 2).sum()]


class TestIntegers:
    def test_points_are_rounded_before_they_are_evaluated_and_recorded(self):
        f = began(mixed())
        assert f(POINTS).tolist() == [1.0, 9 + 2.25, 18.0]
        assert f.best_point.tolist() == [0.0, 1.0]
        assert f(POINTS[1]) == 11.25

    def test_a_trial_without_a_point_in_the_box_ends_at_a_whole_number(self):
        f = began(mixed())
        assert np.isinf(f(np.array([[9.4, 0.3], [-7.6, 0.1]]))).all()
        assert f.best_point.tolist() == [9.0, 0.3]
        assert f([5.5, 0.0]) == np.inf
        assert f.best_point.tolist() == [9.0, 0.3]
        assert f([1.2, 0.5]) == 1.25
        assert f.best_point.tolist() == [1.0, 0.5]

    def test_every_whole_number_is_as_probable_in_an_initial_point(self):
        points = began(mixed()).initial(8000)
        values, counts = np.unique(points[:, 0], return_counts=True)
        assert values.tolist() == list(range(-3, 5))
        assert counts.min() > 850
        assert len(np.unique(points[:, 1])) == 8000

    def test_a_repaired_point_is_rounded(self):
        class Mirrored(FunctionProblem):
            repairs = True

            def repair(self, x):
                return np.abs(x)

        problem = scored(mixed(Mirrored, violations=lambda x: -x), "repair")
        found = problem.assess(np.array([[-1.4, -1.4]]), np.random.default_rng(0))
        assert found.points.tolist() == [[1.0, 1.4]]

    @pytest.mark.parametrize(
        ("options", "sentence"),
        [
            ({"integer": [True]}, "its attribute integer must be 2 flags, one for each variable"),
            ({"lower": [-2.5, 0.0]}, "its integer variable 'x1' is bounded by -2.5; give whole numbers as bounds"),
            ({"upper": [1e3 + 0.5, 1.0]}, "its integer variable 'x1' is bounded by 1000.5; give whole numbers"),
        ],
    )
    def test_what_cannot_be_is_one_sentence(self, options, sentence):
        with pytest.raises(BenchError, match=sentence.replace("(", r"\(")):
            scored(mixed(**options), "death")


def test_both_are_scored_and_the_problem_itself_is_kept():
    for problem in (mixed(), noisy()):
        found = scored(problem, "death")
        assert isinstance(found, Scored)
        assert (found.unscored, found.handling) == (problem, "")
        assert found.violations(POINTS) is None
        assert found.describe(POINTS[0]) == {}
        assert scored(found, "repair") is found


@pytest.mark.slow
def test_a_study_with_both_is_repeated_bit_by_bit(tmp_path):
    study = Study.from_dict(
        {
            "name": "odd", "trials": 2, "budget": 60, "seed": 3,
            "problems": [{"names": ["bbob-noisy-f104-d2-i1", "bbob-mixint-f03-d5-i2", "bbob-constrained-f01-d2-i1"]}],
            "optimizers": [{"name": "gwo", "agents": 6}],
        }
    )  # fmt: skip
    run(study, tmp_path / "odd", n_jobs=1)
    frame = load_results(tmp_path / "odd")
    assert (frame["status"] == "ok").all()
    assert (frame["nfev"] == 60).all()
    assert not verify(tmp_path / "odd", trials=2, n_jobs=1).different


def test_an_honest_trial_without_a_point_in_the_box_is_kept(tmp_path):
    (tmp_path / "outside.py").write_text(
        "def outside(objective, rng):\n    objective(objective.upper + 0.4)\n    objective.stop('tired')\n"
    )
    study = Study.from_dict(
        {
            "name": "odd", "trials": 1, "budget": 60, "problems": [{"name": "bbob-mixint-f03-d5-i2"}],
            "optimizers": [{"name": f"{tmp_path / 'outside.py'}:outside", "label": "outside"}],
        }
    )  # fmt: skip
    run(study, tmp_path / "odd", n_jobs=1)
    (row,) = load_results(tmp_path / "odd").to_dict("records")
    assert (row["status"], row["fun"], row["error"]) == ("ok", np.inf, None)


class TestPointsThatFail:
    @staticmethod
    def fun(x, rng=None):
        if (x[:, 0] > 2).any():
            raise RuntimeError("no convergence")
        return (x**2).sum(axis=1)

    @pytest.mark.parametrize("kind", [mixed, noisy])
    def test_each_counts_and_is_worth_infinity_where_the_study_says_worst(self, kind):
        noiseless = {"noiseless": self.fun} if kind is noisy else {}
        problem = scored(kind(fun=self.fun, **noiseless), "death", "worst")
        f = objective(problem, 10, np.random.default_rng(0))
        assert np.isinf(f(POINTS)).tolist() == [False, True, False]
        assert f(POINTS[1]) == np.inf
        assert (f.nfev, f.raised, np.isfinite(f.fun), f.failures) == (4, None, True, 2)

    def test_else_it_is_raised_and_noted(self):
        f = objective(scored(mixed(fun=self.fun), "death"), 10, np.random.default_rng(0))
        with pytest.raises(RuntimeError, match="no convergence"):
            f(POINTS)
        assert str(f.raised) == "no convergence"

    def test_a_problem_that_computes_point_by_point_computes_none_twice(self):
        seen = []

        def fun(x):
            seen.append(x[0])
            return 1 / (float(x[0]) - 1)

        problem = scored(FunctionProblem(fun, [-3.0], [4.0], vectorized=False), "death", "worst")
        assert problem.evaluate(np.array([[0.0], [1.0], [2.0]])).tolist() == [-1.0, np.inf, 1.0]
        assert (seen, problem.failed) == ([0.0, 1.0, 2.0], 1)
