"""Try to beat the reference fit with long runs of four optimizers on every dataset, clean and noisy.

    python validation/optimum.py [--trials 5] [--budget 300000] [--output results/runs/optimum]

The problems are signature-01 … -20 and noisy-00 … -20 with both levels of noise, and some with a T_f whose windows may
overlap or whose T_d lies between two samples; each optimizer runs in the box or under the constraints, against the
reference fit in the same space. The output is the largest amount by which a run was better, the share of runs that came
within 1% of the reference, and the time of a reference fit. An interrupted run continues when it is started again.
"""

import argparse
from time import perf_counter

import numpy as np

import bench
from problems.backlash import LEVELS
from problems.backlash.signature.problem import FOUND

PERIODIC = {"variant": "pycma", "sigma": 0.25}  # the phase is periodic
OPTIMIZERS = [
    {"name": "bipop-cma-es", "handling": "box", **PERIODIC},
    {"name": "bipop-cma-es", "label": "bipop-cma-es, constrained", "handling": "repair", **PERIODIC},
    {"name": "cma-es-fast", "handling": "box", "agents": 100},
    {"name": "gwo", "handling": "repair", "agents": 300},
]
PERIODS = (0.1, 0.2, 0.3, 0.39, 0.4068)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=5)
    parser.add_argument("--budget", type=int, default=300_000)
    parser.add_argument("--output", default="results/runs/optimum")
    options = parser.parse_args()
    problems = [{"name": f"signature-{level:02d}"} for level in LEVELS]
    for noise in ("low", "high"):
        problems += [
            {"name": f"noisy-{level:02d}", "label": f"noisy-{level:02d} {noise}", "noise": noise}
            for level in (0, *LEVELS)
        ]
    problems += [
        {"name": f"noisy-{level:02d}", "label": f"noisy-{level:02d}, {period:g} s", "period": period}
        for level in (2, 5, 12)
        for period in PERIODS
    ]
    study = bench.Study.from_dict(
        {
            "name": "optimum", "trials": options.trials, "budget": options.budget, "seed": 6,
            "problems": problems, "optimizers": OPTIMIZERS,
        }
    )  # fmt: skip
    bench.run(study, options.output)
    frame = bench.load_results(options.output)
    references, seconds = {}, []
    for period in (0.4, 0.39):
        bench.load_problem("signature-12", period=period).reference()  # compiled before the clock starts
    for entry in study.problems:
        for constrained in (False, True):
            problem = bench.load_problem(entry.name, **entry.options)
            started = perf_counter()
            references[entry.label, constrained] = problem.reference(constrained=constrained).value
            seconds.append(perf_counter() - started)
    handling = {entry.label: entry.options["handling"] == "repair" for entry in study.optimizers}
    reference = np.array(
        [references[row.problem, handling[row.optimizer]] for row in frame[["problem", "optimizer"]].itertuples()]
    )
    above = frame["fun"].to_numpy() - reference
    print(f"{len(frame)} runs of {options.budget:,} evaluations on {len(study.problems)} recordings")
    worst = int(np.argmin(above))
    print(f"the reference was beaten by {max(-above[worst], 0.0):.2g} rps at most ({frame['problem'].iloc[worst]})")
    print(f"it was beaten by more than 1e-7 rps in {int((above < -1e-7).sum())} runs")
    for label in handling:
        own = frame["optimizer"].to_numpy() == label
        print(f"{label}: {np.mean(above[own] <= FOUND * reference[own]):.0%} of the runs came within {FOUND:.0%} of it")
    print(f"a reference fit took {np.median(seconds):.2f} s in the median, {max(seconds):.2f} s at most")


if __name__ == "__main__":
    main()
