"""What an author's own tests need: the contract, and that the method does its work."""

from hill_climber import HillClimber

import bench


def test_it_keeps_the_contract():
    checkup = bench.check_optimizer(HillClimber, bias=False)
    assert checkup, str(checkup)


def test_it_solves_a_sphere():
    sphere = bench.FunctionProblem(lambda x: (x**2).sum(axis=1), [-5] * 4, [7] * 4)
    assert bench.solve(sphere, HillClimber(), budget=2_000, seed=1).fun < 1e-6
