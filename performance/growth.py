"""How an optimizer's own time grows with the dimension and with the number of agents.

    python performance/growth.py

Milliseconds a generation beside the objective, on a sphere, the median of five runs of 30 generations.
"""

from dataclasses import replace
from statistics import median

from overhead import OPTIMIZERS, overhead
from threadpoolctl import threadpool_limits

POINTS = ((300, 2), (300, 7), (300, 20), (300, 50), (100, 7), (1000, 7))  # agents, dimension
GENERATIONS, RUNS = 30, 5


def main() -> None:
    print("ms a generation".ljust(16) + "".join(f"{f'{n} agents, d = {d}':>20}" for n, d in POINTS))
    with threadpool_limits(limits=1):
        for name, optimizer in OPTIMIZERS:
            row = []
            for agents, dimension in POINTS:
                sized = replace(optimizer, agents=agents)  # type: ignore[type-var]
                runs = [overhead(sized, seed, agents, dimension, GENERATIONS) for seed in range(RUNS + 1)]
                row.append(median(runs[1:]))  # the first one compiles
            print(name.ljust(16) + "".join(f"{each:20.3g}" for each in row))


if __name__ == "__main__":
    main()
