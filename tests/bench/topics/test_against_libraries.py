"""The statistics in the CSV files of a report equal those that scipy, statsmodels and pandas make of its trials."""

import numpy as np
import pandas as pd
from numpy.testing import assert_allclose
from scipy import stats
from statsmodels.stats.multitest import multipletests

from bench import Results, Study, load_problem, run
from bench.analysis.direction import COUNTED
from bench.topics.write import write_report

STUDY = {
    "name": "s",
    "trials": 8,
    "budget": 150,
    "targets": "precisions",
    "problems": [{"name": "engineering-spring"}, {"name": "classical-sphere-d2-i1"}],  # the first has failed trials
    "optimizers": [{"name": "gwo", "agents": 10}, {"name": "random-search"}, {"name": "cma-es-fast"}],
}


def test_the_statistics_of_a_report_are_those_of_scipy_and_statsmodels(tmp_path):
    folder = run(Study.from_dict(STUDY), tmp_path / "s", n_jobs=1).folder
    write_report(folder, n_jobs=1)
    trials, cells, tests, times = (
        pd.read_csv(folder / "tables" / f"{name}.csv", keep_default_na=False, na_values=[""])
        for name in ("trials", "comparison", "tests", "running-times")
    )
    values = {
        key: part.to_numpy() for key, part in trials.fillna({"fun": np.inf}).groupby(["problem", "optimizer"]).fun
    }
    assert len(cells) == len(values) == 6
    assert cells["failed"].sum() > 0

    for cell in cells.itertuples():
        x = np.sort(values[cell.problem, cell.optimizer])
        ends = stats.quantile_test(np.arange(len(x)), p=0.5).confidence_interval(0.95)
        assert (cell.n, cell.failed) == (len(x), np.isinf(x).sum())
        assert_allclose([cell.median_low, cell.median_high], x[[int(ends.low), int(ends.high)]])
        if not cell.failed:
            assert_allclose([cell.mean, cell.sd], [x.mean(), pd.Series(x).std()])
            assert_allclose([cell.q1, cell.median, cell.q3], pd.Series(x).quantile([0.25, 0.5, 0.75]))

    for pair in tests.itertuples():
        x, y = values[pair.problem, pair.first], values[pair.problem, pair.second]
        assert_allclose(pair.a12, 1 - stats.mannwhitneyu(x, y).statistic / (len(x) * len(y)))
        assert_allclose([pair.ks_distance, pair.ks_p], stats.ks_2samp(x, y, method="exact"))
    for _, within in tests.groupby("problem"):
        least = multipletests(within["p"], method="holm")[1]
        # Where A12 moves in steps, half a step is taken off, which makes p larger.
        steps = within["ratio"] * (within[["n_first", "n_second"]].min(axis=1) - 1) > COUNTED
        assert_allclose(within["p_holm"], np.maximum(within["p_holm"], least) if steps.any() else least)

    traces = {key[:3]: trace for key, trace in Results(folder).traces.items()}
    sphere = times[(times["problem"] == "classical-sphere-d2-i1") & (times["successes"] > 0)]
    assert len(sphere) > 3
    for row in sphere.itertuples():
        target = load_problem(row.problem).optimum + row.precision
        runs = [traces[row.problem, row.optimizer, trial] for trial in range(row.trials)]
        reached = [trace.evaluations[trace.values <= target] for trace in runs]
        spent = sum(hits[0] if len(hits) else 150 for hits in reached)
        assert_allclose(row.ert, spent / row.successes)
