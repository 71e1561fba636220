"""The committed run of thesis-equal: it is of the shipped study, can be repeated, and says what its README says."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from bench import Study, solve
from bench.plugins.loading import load_optimizer, load_problem

RESULTS = Path(__file__).resolve().parents[3] / "results"
FOLDER = RESULTS / "thesis-equal"


@pytest.fixture(scope="module")
def trials():
    return pd.read_csv(FOLDER / "trials.csv")


@pytest.fixture(scope="module")
def compared():
    """The rows of equal populations, by the swarm's label."""
    table = pd.read_csv(FOLDER / "same-conditions.csv")
    return table[table["conditions"] != "as reported"].set_index("second")


def test_it_is_whole_and_of_the_shipped_study(trials):
    study = Study.load(FOLDER / "study.toml")
    assert study == Study.load("thesis-equal")
    assert len(trials) == len(study.problems) * len(study.optimizers) * study.trials == 5400
    assert (trials["status"] == "ok").all()
    assert trials["seed"].is_unique


def test_the_chances_are_those_of_the_trials(trials, compared):
    runs = trials.groupby(["problem", "optimizer"])["fun"].apply(np.array).unstack()
    assert len(compared) == 12
    for swarm, row in compared.iterrows():
        assert row["first"] == f"cma-es {swarm.split()[1]}"
        pairs = [np.meshgrid(*each) for each in zip(runs[row["first"]], runs[swarm], strict=True)]
        ties = [np.isclose(*pair, rtol=1e-10, atol=0) for pair in pairs]
        wins = [np.where(tie, 0.5, one < other) for tie, (one, other) in zip(ties, pairs, strict=True)]
        by_hand = np.mean(wins)
        assert row["probability"] == pytest.approx(by_hand)


def test_the_readme_prints_the_table(trials, compared):
    medians = trials.pivot_table(index="problem", columns="optimizer", values="fun", aggfunc="median")
    assert medians.filter(like=" 300").idxmin(axis=1).value_counts().to_dict() == {
        "cma-es 300": 9, "gwo 300": 8, "alo 300": 1
    }  # fmt: skip
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    blocks = text.split("| 300, equal |")[1]
    rows = re.findall(r"\| ([A-Z]+) \| (\d+) \| (\.\d\d) \[(\.\d\d), (\.\d\d)\]", "|" + blocks)
    assert len(rows) == 12
    for (name, lower, *numbers), agents in zip(rows, [300] * 4 + [100] * 4 + [30] * 4, strict=True):
        swarm = f"{name.lower()} {agents}"
        assert int(lower) == (medians[f"cma-es {agents}"] < medians[swarm]).sum()
        for printed, value in zip(numbers, compared.loc[swarm, ["probability", "low", "high"]], strict=True):
            assert float(printed) == pytest.approx(value, abs=0.00501)


@pytest.mark.parametrize("optimizer", ["gwo 100", "da 30"])
def test_a_row_is_repeated_by_its_seed_and_options(trials, optimizer):
    row = trials[(trials["problem"] == "signature-08") & (trials["optimizer"] == optimizer)].iloc[3]
    name, agents = optimizer.split()
    problem = load_problem("signature-08", unit="rpm")
    assert (
        solve(problem, load_optimizer(name, agents=int(agents)), budget=60_000, seed=int(row["seed"])).fun == row["fun"]
    )
