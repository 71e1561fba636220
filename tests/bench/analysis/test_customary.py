"""The customary tests, against scipy and Demšar's example."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import mannwhitneyu, wilcoxon
from statsmodels.stats.multitest import multipletests

from bench.analysis.customary import customary, friedman


def frame_of(table, trials=1, spread=0.0):
    """Return runs of an optimizer a column and a problem a row around the values of a table."""
    rng = np.random.default_rng(1)
    rows = [
        (problem, optimizer, trial, "ok", value + spread * rng.standard_normal())
        for problem, values in table.iterrows()
        for optimizer, value in values.items()
        for trial in range(trials)
    ]
    return pd.DataFrame(rows, columns=["problem", "optimizer", "trial", "status", "fun"])


def table_of(rows, optimizers="abcd"):
    names = list(optimizers[: len(rows[0])])
    return pd.DataFrame(rows, index=[f"p{i}" for i in range(len(rows))], columns=names, dtype=float)


def test_friedman_is_that_of_demsar_s_example(demsar):
    """2006, section 3.2.2: 9.28, over 1 - 78 / 840 for the ties."""
    frame = frame_of(demsar)
    assert "4 optimizers on 14 problems: chi-squared = 10.23 with 3 degrees of freedom, p = 0.017." in friedman(frame)
    ranks = customary(frame, "C4.5").set_index("optimizer")["mean_rank"]
    assert ranks.tolist() == pytest.approx([3.143, 2.0, 2.893, 1.964], abs=1e-3)


def test_p_and_signs_are_scipy_s():
    middle = table_of(np.add.outer(np.arange(8.0), [0.0, 0.3, 2.0]).tolist())
    frame = frame_of(middle, trials=9, spread=0.5)
    found = customary(frame, "a").set_index("optimizer")
    wide = frame.groupby(["problem", "optimizer"])["fun"].median().unstack()
    p = [wilcoxon(wide["a"] - wide[rival]).pvalue for rival in "bc"]
    assert found.loc[["b", "c"], "p"].tolist() == pytest.approx(p)
    assert found.loc[["b", "c"], "p_holm"].tolist() == pytest.approx(multipletests(p, method="holm")[1])
    runs = frame.groupby(["problem", "optimizer"])["fun"].agg(list).unstack()
    clear = [mannwhitneyu(one, two).pvalue <= 0.05 for one, two in zip(runs["a"], runs["c"], strict=True)]
    assert (found.loc["c", "better"], found.loc["c", "alike"]) == (sum(clear), 8 - sum(clear))
    assert found.loc["c", "worse"] == 0
    assert np.isnan(found.loc["a", "p"])


def test_what_is_not_possible_is_said():
    few = customary(frame_of(table_of([(1, 2)] * 5), trials=3), "a")
    assert few["note"].tolist() == ["", "fewer than six problems differ, so no p could be below 0.05"]
    assert few["p"].isna().all()
    lost = frame_of(table_of([(1, 2)] * 8), trials=3)
    lost.loc[lost["optimizer"] == "b", "status"] = "failed"
    assert customary(lost, "a")["note"].tolist()[1].startswith("a median is infinite")
    assert "needs three optimizers" in friedman(lost)
    assert "all medians of a problem are equal" in friedman(frame_of(table_of([(1, 1, 1)] * 3)))
