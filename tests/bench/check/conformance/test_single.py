"""One run in a process of a check: a sentence on what fails."""

import pytest

from bench import BenchError, FunctionProblem, Optimizer, load_optimizer
from bench.check.conformance.single import single_run


class Raising(Optimizer):
    """Raises what no handler of exceptions catches."""

    def minimize(self, objective, rng):
        raise SystemExit("boom")


@pytest.mark.parametrize("name", ["the optimizer", "mine"])
def test_an_optimizer_that_raises_is_named_in_one_sentence(name):
    problem = FunctionProblem(lambda x: (x**2).sum(axis=1), [-1.0], [1.0], name="bowl", vectorized=True)
    with pytest.raises(BenchError, match=f"^{name} failed on bowl: SystemExit: boom$"):
        single_run(problem, Raising(), 9, 0, name)


def test_a_problem_that_raises_is_blamed_itself():
    problem = FunctionProblem(lambda x: 1 / 0, [-1.0], [1.0], name="hole")
    with pytest.raises(BenchError, match=r"^hole failed: ProblemError: ZeroDivisionError: division by zero$"):
        single_run(problem, load_optimizer("random-search"), 9, 0)
