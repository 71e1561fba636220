"""Tune two optimizers with optuna on training problems, and compare defaults and tuned values on others.

python tune.py        # needs optuna: pip install '.[optuna]' in the clone
"""

import numpy as np
import optuna

import bench

# --- input ---------------------------------------------------------------
TRAIN = [f"classical-{name}-d5-i1" for name in ("sphere", "rosenbrock", "rastrigin", "ackley")]
TEST = [f"classical-{name}-d5-i1" for name in ("ellipsoid", "griewank", "levy", "zakharov")]
SPACES = {  # what is worth trying of each parameter
    "cma-es": {"sigma": (0.05, 1.0)},
    "scipy:differential_evolution": {"mutation": (0.2, 1.0), "recombination": (0.1, 1.0)},
}
CONFIGURATIONS, RUNS, BUDGET = 20, 3, "100 * d"  # the same for every optimizer; the budget is that of the study
folder = "results/runs/tuned"


def score(name, options):
    """Return the mean over the training problems of log10 of the median error; lower is better."""
    optimizer, errors = bench.load_optimizer(name, **options), []
    for problem in map(bench.load_problem, TRAIN):
        ends = [bench.solve(problem, optimizer, budget=BUDGET, seed=seed).fun for seed in range(RUNS)]
        errors.append(max(np.median(ends) - problem.optimum, 1e-8))
    return float(np.log10(errors).mean())


def tuned(name):
    """Return the best configuration of an optimizer; its defaults are the first to be tried."""
    space, defaults = SPACES[name], bench.load_optimizer(name)
    search = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=0))
    search.enqueue_trial({key: getattr(defaults, key) for key in space})
    search.optimize(
        lambda trial: score(name, {key: trial.suggest_float(key, *ends) for key, ends in space.items()}),
        CONFIGURATIONS,
    )
    print(f"{name}: {search.trials[0].value:.2f} by default, {search.best_value:.2f} with {search.best_params}")
    return search.best_params


# --- go ------------------------------------------------------------------
optuna.logging.set_verbosity(optuna.logging.WARNING)
optimizers = []
for name in SPACES:
    optimizers += [{"name": name}, {"name": name, "label": f"{name}-tuned", **tuned(name)}]
study = {"name": "tuned", "trials": 15, "budget": BUDGET, "problems": [{"names": TEST}], "optimizers": optimizers}
bench.run(bench.Study.from_dict(study), folder)

# --- post-process --------------------------------------------------------
bench.write_report(folder)
print(bench.load_results(folder).groupby(["problem", "optimizer"])["fun"].median().unstack().to_string())
