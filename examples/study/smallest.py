"""The study of smallest.toml in Python: python smallest.py."""

import bench

# --- input ---------------------------------------------------------------
study = bench.Study.from_dict(
    {
        "name": "smallest",
        "trials": 15,
        "budget": 6000,
        "problems": [{"names": ["classical-rosenbrock-d5-i1", "engineering-spring"]}],
        "optimizers": [{"name": "gwo", "agents": 50}, {"name": "cma-es"}],
    }
)
folder = "results/runs/smallest"

# --- go ------------------------------------------------------------------
bench.run(study, folder, n_jobs=2)

# --- post-process --------------------------------------------------------
frame = bench.load_results(folder)  # one row per trial
bench.write_report(folder)
print(frame.groupby(["problem", "optimizer"])["fun"].median().unstack())
