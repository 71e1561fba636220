"""cma-es-fast is pycma's algorithm: the same points from the same draws, and the same distribution of what it finds."""

import math
from importlib.metadata import version

import numpy as np
import pytest
from cma.utilities.math import Mh
from scipy.stats import ks_2samp

from bench import FunctionProblem, solve
from optimizers.cma_es import CMAES
from optimizers.cma_es_fast import CMAESFast
from tests.optimizers import sample_cma
from tests.optimizers.observed import Watched
from tests.optimizers.sample_cma import CELLS, SEEDS, mirror

ALPHA = 0.01
as_pycma_4_5 = pytest.mark.skipif(
    tuple(int(part) for part in version("cma").split(".")[:2]) < (4, 5),
    reason="pycma before 4.5 damps the step size of large populations less",
)


def ellipsoid(exponent, rotation):
    scales = 10 ** np.linspace(0, exponent, 5)
    return lambda x: (scales * ((x - 1) @ rotation) ** 2).sum(axis=1)


def rough(x):
    return (x**2).sum(axis=1) + 1e-3 * np.abs(np.sin(1e7 * x)).sum(axis=1)


FUNCTIONS = {
    "sphere": ellipsoid(0, np.eye(5)),
    "along the axes, condition 1e10": ellipsoid(10, np.eye(5)),
    "rotated, condition 1e6": ellipsoid(6, mirror(5)),
    "rosenbrock": sample_cma.rosenbrock,
    "steps": lambda x: np.floor(np.abs(x)).sum(axis=1),
    "half of it infinite": lambda x: np.where(x[:, 0] < 0, np.inf, (x**2).sum(axis=1)),
    "slope into a corner": lambda x: x.sum(axis=1),
}


@pytest.fixture
def exact_norm(monkeypatch):
    """Let pycma compare path lengths with the exact expectation; its approximation is 5e-5 off."""

    def expected(d):
        return math.sqrt(2) * math.exp(math.lgamma((d + 1) / 2) - math.lgamma(d / 2))

    monkeypatch.setattr(Mh, "chiN", staticmethod(expected))


@pytest.mark.slow
@as_pycma_4_5
@pytest.mark.parametrize(("agents", "active"), [(None, True), (7, True), (60, True), (300, True), (60, False)])
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.usefixtures("exact_norm")
def test_the_same_draws_give_pycma_s_points(name, agents, active):
    batches = []
    for optimizer in (CMAES, CMAESFast):
        problem = Watched(FUNCTIONS[name], [-5, -5, -5, 0, -100], [5, 5, 5, 0.1, 1000])
        run = optimizer(agents=agents, active=active)
        # Later, in the corner of the slope, values of 300 agents tie up to rounding, which processors do differently.
        solve(problem, run, budget=10 * run.population(5), seed=3)
        batches.append(problem.batches)
    assert len(batches[0]) == len(batches[1])
    for theirs, ours in zip(*batches, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9)


STOPS = [
    ("tolfun", FUNCTIONS["sphere"], [-5, 5], {}),
    ("tolfun", FUNCTIONS["along the axes, condition 1e10"], [-5, 5], {}),  # C's coordinates are scaled
    ("tolfunhist", lambda x: 1e9 + (x**2).sum(axis=1), [-5, 5], {}),
    ("tolflatfitness", FUNCTIONS["steps"], [-5, 5], {}),
    ("tolx", lambda x: 1e6 * np.abs(x - 1).sum(axis=1), [-5, 5], {}),
    ("tolfacupx", FUNCTIONS["sphere"], [-5, 5], {"sigma": 1e-7}),
    ("tolstagnation", rough, [-5, 5], {}),
    ("tolxstagnation", lambda x: np.sin(1e9 * x).sum(axis=1), [0, 1e-8], {}),
    ("noeffectaxis", lambda x: 1e6 * np.abs(x - 1e9 - 0.5).sum(axis=1), [1e9, 1e9 + 1], {}),
    ("tolupsigma", ellipsoid(12, mirror(5)), [-5, 5], {"agents": 40}),  # and C's axes are changed
]


@pytest.mark.slow
@as_pycma_4_5
@pytest.mark.parametrize(("reason", "function", "bounds", "options"), STOPS)
@pytest.mark.usefixtures("exact_norm")
def test_a_run_ends_when_pycma_s_ends_and_for_its_reason(reason, function, bounds, options):
    problem = FunctionProblem(function, [bounds[0]] * 5, [bounds[1]] * 5)
    theirs, ours = (solve(problem, run(**options), budget=20_000, seed=4) for run in (CMAES, CMAESFast))
    assert ours.stop == theirs.stop == reason
    # Rounding grows along a run; and a step too small to count, of which one axis a generation is asked, is rounding.
    assert ours.nfev == pytest.approx(theirs.nfev, rel=0.2 if reason == "noeffectaxis" else 0.05)


@pytest.fixture(scope="module")
def pycma():
    """The stored runs of pycma by function and population."""
    _, rows = sample_cma.load()
    return dict(iter(rows.groupby(["function", "agents"])))


def runs(cell, agents=None, seeds=SEEDS, **options):
    """Return the best values and the evaluations of runs of cma-es-fast, of other seeds than the stored ones."""
    cell = cell if agents is None else cell._replace(agents=agents)
    rows = [sample_cma.run(cell, CMAESFast(agents=cell.agents, **options), 1000 + seed) for seed in seeds]
    return {key: [row[key] for row in rows] for key in ("best", "evaluations")}


def p_values(theirs, ours):
    return [
        ks_2samp(theirs[key], ours[key]).pvalue
        for key in ("best", "evaluations")
        if len({*theirs[key], *ours[key]}) > 1  # runs that all spend the budget say nothing by their lengths
    ]


@pytest.mark.slow
def test_what_runs_find_and_when_they_stop_is_distributed_as_pycma_s(pycma):
    p = [value for cell in CELLS for value in p_values(pycma[cell.function, cell.agents], runs(cell))]
    assert len(p) == len(CELLS) + 2  # runs stop before their budget on two functions
    assert min(p) * len(p) > ALPHA  # Holm's method rejects none


@pytest.mark.sampled(1)
@pytest.mark.parametrize("cell", CELLS)
def test_the_stored_runs_are_still_pycma_s(cell):
    made_with, rows = sample_cma.load()
    if made_with != version("cma"):
        pytest.skip(f"the stored runs are of pycma {made_with}, this is {version('cma')}")
    row = rows[(rows.function == cell.function) & (rows.agents == cell.agents)].iloc[7]
    again = sample_cma.run(cell._replace(patience=cell.generations), CMAES(agents=cell.agents), int(row.seed))
    assert again["early"] == pytest.approx(row.early, rel=1e-5)  # later values depend on the machine's LAPACK
