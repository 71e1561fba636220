"""The runs of an atlas, and the parameters that have no effect."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pytest

from bench import Optimizer, parameter
from bench.atlas.runs import MEASURES, PROBLEMS, AtlasRun, alternatives, measure, probe, run, survey
from bench.atlas.table import parse

FILE = '''
from dataclasses import dataclass
from bench import Optimizer, parameter

@dataclass(frozen=True)
class Swarm(Optimizer):
    """Like a swarm whose velocity is computed and thrown away."""

    agents: int = parameter(5, minimum=1)
    inertia: float = parameter(0.7, minimum=0, maximum=1)
    step: float = parameter(0.1, minimum=0, maximum=1)

    def minimize(self, objective, rng):
        x, velocity = objective.initial(self.agents), 0.0
        while True:
            objective(x)
            new = self.inertia * velocity + rng.standard_normal(x.shape)
            x = objective.repair(x + 200 * self.step * rng.standard_normal(x.shape))

@dataclass(frozen=True)
class Wild(Swarm):
    def minimize(self, objective, rng):
        raise RuntimeError("it cannot")

@dataclass(frozen=True)
class Exiting(Swarm):
    def minimize(self, objective, rng):
        import os
        os._exit(3)

@dataclass(frozen=True)
class Lucky(Swarm):
    def minimize(self, objective, rng):
        import os
        while True:
            objective(objective.lower + (objective.upper - objective.lower) * os.urandom(1)[0] / 255)
'''


@pytest.fixture(scope="module")
def swarm(tmp_path_factory):
    """Return the path of a file with optimizers."""
    file = tmp_path_factory.mktemp("mine") / "swarm.py"
    file.write_text(FILE, encoding="utf-8")
    return file


def table(swarm, *names):
    lines = [f"[[methods.swarm.implementations]]\nname = '{swarm}:{name}'\nlabel = '{label}'" for label, name in names]
    return parse("[methods.swarm]\ngeneration = 5\n" + "\n".join(lines), "mine.toml")


def test_a_parameter_without_effect_is_found_and_one_with_effect_is_not(swarm):
    tasks = [AtlasRun(problem, 60, 3, 5) for problem in ("sphere moved", "Rastrigin moved")]
    assert probe(f"{swarm}:Swarm", {}, "inertia", [0.35, 1.0], tasks) == {"tried": "0.35, 1.0"}
    assert probe(f"{swarm}:Swarm", {}, "step", [0.2], tasks) == {"tried": ""}
    assert probe(f"{swarm}:Swarm", {}, "inertia", [7.0, 0.35], tasks) == {"tried": "0.35"}  # 7 is refused


def test_a_run_gives_its_measures(swarm):
    found = run(f"{swarm}:Swarm", {}, AtlasRun("sphere centred", 60, 3, 5))
    start, following, course, final = found["measures"]
    assert found["evaluations"] == 60
    assert final > 0
    assert np.log10(final) <= course
    assert start > np.log10(final)
    assert following > np.log10(final)
    assert run(f"{swarm}:Swarm", {}, AtlasRun("sphere centred", 60, 3, 5))["points"] == found["points"]
    assert run(f"{swarm}:Swarm", {}, AtlasRun("sphere centred", 60, 4, 5))["points"] != found["points"]


def test_the_first_generation_is_measured_by_its_median():
    class Fixed(Optimizer):
        def minimize(self, objective, rng):
            for value in (1.0, 10.0, 10.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0):
                objective(np.full(5, value))
            objective.stop("done")

    found = measure(Fixed(), AtlasRun("sphere centred", 60, 0, 3))
    assert found["measures"][MEASURES.index("start")] == pytest.approx(np.log10(500))
    assert found["measures"][MEASURES.index("next")] == pytest.approx(np.log10(5))
    assert found["measures"][MEASURES.index("final")] == 5.0
    assert found["evaluations"] == 9


def test_other_values_of_parameters_are_those_it_accepts():
    @dataclass(frozen=True)
    class Mine(Optimizer):
        agents: int = parameter(5, minimum=1)
        kind: Literal["a", "b", "c"] = "b"
        flag: bool = True
        size: int = parameter(4, minimum=3, maximum=5)
        share: float = parameter(0.5, minimum=0, maximum=1)
        limit: float | None = None
        tolerance: float = parameter(1e-8, tune=[])
        threads: int = 1

        def minimize(self, objective, rng):
            """Do nothing."""

    found = alternatives(Mine(), ["threads"])
    assert found == {"kind": ["a", "c"], "flag": [False], "size": [3, 5], "share": [1.0, 0.25, 0]}


@pytest.mark.slow
def test_failures_cost_their_own_implementation_alone(swarm):
    seen = []
    names = ("Swarm", "Swarm", "Wild", "Exiting", "Lucky", "Nobody")
    one, copy, wild, exiting, lucky, missing = survey(
        table(swarm, *((f"{name} {number}", name) for number, name in enumerate(names))),
        trials=2, budget=60, jobs=2, on_progress=lambda *shown: seen.append(shown),
    )  # fmt: skip
    assert one.failed == copy.failed == ""
    assert list(one.measures) == list(PROBLEMS)
    assert one.measures["sphere moved"].shape == (2, len(MEASURES))
    assert list(one.dead) == list(copy.dead) == ["inertia"]
    assert (one.measures["sphere moved"] != copy.measures["sphere moved"]).any()  # seeds of their own
    assert wild.failed == "the optimizer failed on sphere: RuntimeError: it cannot"
    assert exiting.failed == "the optimizer ended its process (exit code 3)"
    assert (lucky.failed, lucky.repeatable, lucky.dead) == ("", False, {})
    assert "Nobody" in missing.failed
    assert seen[0][1] == 0
    assert seen[-1][1] < seen[-1][2]


@pytest.mark.slow
def test_numbers_depend_neither_on_jobs_nor_on_other_implementations(swarm):
    _, one = survey(table(swarm, ("other", "Wild"), ("one", "Swarm")), trials=2, budget=60, jobs=2)
    [same] = survey(table(swarm, ("one", "Swarm")), trials=2, budget=60, jobs=1)
    for problem in PROBLEMS:
        np.testing.assert_array_equal(one.measures[problem], same.measures[problem])
        np.testing.assert_array_equal(one.behaviours[problem], same.behaviours[problem])


def test_a_budget_below_a_generation_is_a_failure_with_its_reason(swarm):
    methods = parse(f"[methods.a]\nimplementations = [{{name = '{swarm}:Swarm', options = {{agents = 90}}}}]", "mine")
    [found] = survey(methods, trials=2, budget=60, jobs=1)
    assert "below one generation of 'Swarm'" in found.failed
