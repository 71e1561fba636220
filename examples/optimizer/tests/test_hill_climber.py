"""What an author's own tests need: the contract, and that the method does its work."""

from hill_climber import HillClimber

import bench
from bench.testing import parametrize_with_checks


@parametrize_with_checks([HillClimber, HillClimber(sigma=0.05)])
def test_it_keeps_the_contract(check):
    check()


def test_it_solves_a_sphere():
    sphere = bench.FunctionProblem(lambda x: (x**2).sum(axis=1), [-5] * 4, [7] * 4)
    assert bench.solve(sphere, HillClimber(), budget=2_000, seed=1).fun < 1e-6
