"""Audits: what is accepted, each reason for refusal, and a record whose keys stay."""

import json
import re
from pathlib import Path
from textwrap import dedent

import pytest

from bench import BenchError
from bench.check.audit import audit, drawn
from bench.sandbox import bubblewrap

try:
    bubblewrap.find()
    REASON = ""
except BenchError as error:
    REASON = str(error)
needed = pytest.mark.skipif(bool(REASON), reason=REASON or "bubblewrap can be used")
PAGE = Path(__file__).parents[3] / "docs" / "reference" / "audit.md"

CANDIDATES = """
    import time

    import numpy as np

    def climbs(objective, rng, step=0.2):
        x = objective.initial(1)[0]
        best, width = objective(x[np.newaxis])[0], step * (objective.upper - objective.lower)
        while True:
            y = np.clip(x + width * rng.standard_normal(x.shape), objective.lower, objective.upper)
            value = objective(y[np.newaxis])[0]
            x, best, width = (y, value, 1.5 * width) if value <= best else (x, best, 0.9 * width)

    def repeats(objective, rng):
        x = objective.initial(1)
        while True:
            objective(x)

    def strays(objective, rng):
        while True:
            objective(objective.initial(1) + 1e6)

    def depends(objective, rng):
        number = time.perf_counter_ns() if objective.dimension == 2 and objective.budget == 60 else 1
        while True:
            objective(objective.lower + (objective.upper - objective.lower) * (number % 97) / 97)
            number += 1

    def fails(objective, rng):
        objective(objective.initial(1))
        if objective.dimension == 3 and objective.budget == 60:
            raise ValueError("not here")
        objective.stop("early")
"""
SMALL = {"problems": ["sphere-2", "sphere-3"], "baselines": ["scatter"], "trials": 4, "budget": 60, "jobs": 1}


@pytest.fixture(scope="module")
def candidates(tmp_path_factory):
    path = tmp_path_factory.mktemp("candidates") / "mine.py"
    path.write_text(dedent(CANDIDATES))
    return path


def codes(record):
    return [reason["code"] for reason in record["reasons"]]


def test_the_seed_draws_other_instances_of_the_same_functions():
    assert drawn(1) == drawn(1) != drawn(2)
    assert {re.sub("i[0-9]+$", "", name) for name in drawn(1)} == {re.sub("i[0-9]+$", "", name) for name in drawn(2)}


def test_without_bubblewrap_there_is_no_verdict(monkeypatch, candidates):
    monkeypatch.setattr("shutil.which", lambda _: None)
    with pytest.raises(BenchError, match="needs bubblewrap"):
        audit(f"{candidates}:climbs")


@needed
def test_one_that_does_not_load_is_refused_with_the_reason(bench_here, candidates):
    done = bench_here("audit", f"{candidates}:flies", "--json")
    record = json.loads(done.stdout)
    assert done.returncode == 1
    assert codes(record) == ["loading"]
    assert "holds no optimizer called 'flies'" in record["reasons"][0]["text"]
    assert (record["accepted"], record["check"], record["repetition"], record["comparison"]) == (False, [], None, None)


@needed
@pytest.mark.slow
def test_a_good_one_is_accepted_and_its_record_has_the_keys_of_the_page(bench_here, candidates):
    words = [f"--problem={problem}" for problem in SMALL["problems"]]
    limits = ("--baseline", "scatter", "--trials", 4, "--budget", 60, "--jobs", 1)
    done = bench_here("audit", f"{candidates}:climbs", "--json", "--set", "step=0.1", *words, *limits)
    assert done.returncode == 0, done.stdout + done.stderr
    record = json.loads(done.stdout)
    assert (record["accepted"], record["reasons"], record["options"]) == (True, [], {"step": 0.1})
    assert record["repetition"] == {"problem": "sphere-2", "trial": 0, "same": True, "difference": ""}
    (baseline,) = record["comparison"]["baselines"]
    assert baseline["outcome"] == "better"
    assert baseline["low"] <= baseline["a12"] <= baseline["high"]
    assert baseline["p_holm"] == baseline["p"] <= 0.05
    page = set(re.findall("`([a-z0-9_]+)`", PAGE.read_text(encoding="utf-8")))
    verdict, problem = record["check"][0], baseline["problems"][0]
    for part in (record, record["repetition"], record["comparison"], baseline, problem, verdict):
        assert part.keys() <= page, part.keys() - page


@needed
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "code", "words"),
    [
        ("strays", "contract", "box: "),
        ("depends", "repetition", "differs where a trial is made again"),
        ("fails", "trials", "4 of 8 trials did not finish: ValueError: not here"),
        ("repeats", "worse", "it is worse than scatter: it wins"),
    ],
)
def test_each_reason_for_refusal(candidates, name, code, words):
    record = audit(f"{candidates}:{name}", **SMALL | {"trials": 4 if name == "fails" else 12})
    assert (record["accepted"], codes(record)[0]) == (False, code), record["reasons"]
    assert any(words in reason["text"] for reason in record["reasons"]), record["reasons"]


@needed
def test_a_comparison_needs_two_trials_and_a_baseline(candidates):
    with pytest.raises(BenchError, match="at least one baseline"):
        audit(f"{candidates}:climbs", **SMALL | {"baselines": []})
    with pytest.raises(BenchError, match="at least 2 trials"):
        audit(f"{candidates}:climbs", **SMALL | {"trials": 1})
