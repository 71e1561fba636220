"""A loop of LLaMEA whose candidates bench.Evaluator judges; here eight prepared answers stand for a language model.

    pip install llamea, in an environment that has backlash-bench
    python loop.py

For a real one, give LLaMEA a model of ``llamea.llm``, such as ``OpenAI_LLM``, in the place of ``Prepared``.
"""

import sys
from contextlib import redirect_stdout
from itertools import cycle

from llamea import LLaMEA
from llamea.llm import Dummy_LLM

import bench

ANSWER = """# Description: {name}, a random search that narrows its box.
# Code:
```python
import numpy as np

class {name}:
    def __init__(self, budget, dim):
        self.budget, self.dim = budget, dim

    def __call__(self, func):
        f, x, width = np.inf, (func.bounds.lb + func.bounds.ub) / 2, 1.0
        for _ in range(self.budget):
            y = np.clip(x + width * np.random.uniform(func.bounds.lb, func.bounds.ub), func.bounds.lb, func.bounds.ub)
            value = func(y)
            width *= {shrink}
            if value < f:
                f, x = value, y
        return f, x
```
"""
SHRINKS = [1, 0.99, 0.98, 0.97, 0.95, 0.9, "1 / 0", "missing"]  # the last two fail


class Prepared(Dummy_LLM):
    """Answers any question with the next prepared candidate."""

    def __init__(self) -> None:
        super().__init__()
        answers = [ANSWER.format(name=f"Narrowing{n}", shrink=each) for n, each in enumerate(SHRINKS)]
        self.answers = cycle(answers)

    def query(self, session_messages: list[dict[str, str]]) -> str:  # noqa: ARG002
        """Return the next answer, whatever is asked."""
        return next(self.answers)


def main(generations: int = 5, *, sandbox: bool = True) -> None:
    """Generate, judge, and compare the best candidate once on problems that no candidate was chosen on."""
    with bench.Evaluator(
        train="bbob-f0[1-5]-d2-i1", test="bbob-f0[1-5]-d2-i[6-8]", budget=200, timeout=30, sandbox=sandbox
    ) as judge:
        search = LLaMEA(
            judge.llamea, Prepared(), n_parents=2, n_offspring=2, budget=2 * generations, log=False,
            parallel_backend="threading",
        )  # fmt: skip
        best = search.run()
        with redirect_stdout(sys.__stdout__):  # LLaMEA's threads may leave it redirected
            print(f"best: {best.name} {best.fitness:.3f}")
            print(judge.final(best.code, trials=3))
        judge.log("runs.jsonl")


if __name__ == "__main__":
    main(sandbox="--no-sandbox" not in sys.argv)
