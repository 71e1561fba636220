"""The runs from which biases are judged: their record, their seeds, and optimizers that fail, crash or lie in them."""

import pytest

from bench import BenchError
from bench.check.runs import BOXES, Runs, make_runs, summary
from tests.bench.check import biased, faulty, unrepeatable
from tests.bench.check.biased import LITTLE, SHORT, Chains, Clipping


def made_here(optimizer, **sizes):
    (made,) = make_runs([optimizer], dimension=2, **LITTLE, **sizes)
    assert isinstance(made, Runs)
    return made


def failures(*optimizers):
    """Return why each failed, or None."""
    made = make_runs(optimizers, dimension=2, runs=1, noise_runs=3, n_jobs=2, **SHORT)
    return [str(each) if isinstance(each, BenchError) else None for each in made]


def test_runs_are_kept_as_shares_of_their_box():
    made = made_here(Clipping(), runs=1, noise_runs=3)
    assert [len(those) for those in made.noise.values()] == [3, 3]
    for each in (*made.noise["[-1, 1]"], *made.centred["sphere"]):
        assert each.first.shape == (20, 2)
        assert 0.2 < each.first.mean() < 0.8
        assert ((each.x >= 0) & (each.x <= 1)).all()
    assert made.centred["sphere"][0].x == pytest.approx(0.5, abs=1e-3)
    assert made.moved["sphere"][0].x == pytest.approx(0.6, abs=1e-3)
    assert all(0 < run.clamped < 0.5 for run in made.noise["[0, 1]"])


def test_a_run_is_the_same_among_fewer_others():
    many, few = (made_here(Chains(), runs=number, noise_runs=number) for number in (2, 1))
    assert [run.course for run in few.moved["sphere"]] == [run.course for run in many.moved["sphere"][:1]]
    for box in BOXES:
        assert [run.course for run in few.noise[box]] == [run.course for run in many.noise[box][:1]]


def test_an_optimizer_that_fails_or_crashes_costs_the_others_nothing():
    found = failures(
        biased.Exiting(), Chains(), biased.Raising(), faulty.Endless(), unrepeatable.Locked(), Chains(agents=5)
    )
    assert [each is None for each in found] == [False, True, False, False, False, True]
    assert found[0] == "the optimizer failed: its process ended with exit code 1"
    assert found[2] == "the optimizer failed on sphere: ZeroDivisionError: boom"
    assert "failed: went on asking for values after its budget was spent; let BudgetExhausted pass" in found[3]
    assert "cannot be sent to another process: TypeError: cannot pickle" in found[4]


@pytest.mark.parametrize(
    "answer", [None, 5, [], "x", {}, {"x": [1], "first": [1], "best": 1, "clamped": 0, "course": ""}]
)
def test_what_is_no_record_is_refused(answer):
    with pytest.raises(BenchError, match="gave an answer that is no record of a run"):
        summary(answer)
